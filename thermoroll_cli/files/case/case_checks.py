"""What must hold between the keys of a case, beyond the range of each."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from thermoroll_cli.files.case.case_model import THERMAL_CONSTANTS, MaterialTable, RecirculationTable, TwoMaterials
from thermoroll_cli.files.case.toml_positions import KeyPath
from thermoroll_cli.steady_state.derived import contact_width

Sections = Mapping[str, Any]
"""The tables of a case that are valid by themselves, as models of `case_model`; None for a table left out."""


@dataclass(frozen=True)
class Conflict:
    """Keys that do not go together: the message stands at `path` and may refer to `other`."""

    path: KeyPath
    message: str
    allowed: str = ""
    hint: str = ""
    other: KeyPath = ()


def conflicts(sections: Sections) -> Iterator[Conflict]:
    """Every conflict between keys whose tables are valid."""
    for check in (_exclusive_keys, _convexity, _friction_limit, _thermal_constants, _bulk_temperatures, _recirculation,
                  _subsurface):
        yield from check(sections)


def heat_is_on(sections: Sections) -> bool:
    """Whether a case asks for heat: by saying so, or by giving thermal constants without a [thermal] table."""
    thermal = sections["thermal"]
    if thermal is not None:
        return bool(thermal.heat)
    return any(getattr(material, key) is not None for _, material in _materials(sections) for key in THERMAL_CONSTANTS)


def _exclusive_keys(sections: Sections) -> Iterator[Conflict]:
    numerics = sections.get("numerics")
    if numerics is not None and numerics.grid is not None and numerics.accuracy is not None:
        yield Conflict(
            ("numerics", "accuracy"),
            "cannot be given together with numerics.grid",
            allowed="a grid, or an accuracy for which a grid is picked",
            other=("numerics", "grid"),
        )
    creepage, force = sections.get("creepage"), sections.get("force")
    for direction in ("longitudinal", "lateral"):
        key = f"{direction}_N"
        if creepage and force and getattr(creepage, direction) is not None and getattr(force, key) is not None:
            yield Conflict(
                ("force", key),
                f"cannot be given together with creepage.{direction}",
                allowed="a force, or a creepage, in each direction",
                other=("creepage", direction),
            )


def _convexity(sections: Sections) -> Iterator[Conflict]:
    geometry = sections.get("geometry")
    if geometry is None:
        return
    for axis in "xy":
        lower_key, upper_key = f"lower_radius_{axis}_mm", f"upper_radius_{axis}_mm"
        lower, upper = getattr(geometry, lower_key), getattr(geometry, upper_key)
        if lower is None or upper is None:
            continue
        curvature = 1.0 / lower + 1.0 / upper
        if curvature > 0.0:
            continue
        if math.isinf(lower) and math.isinf(upper):
            reason, hint = "both bodies are flat", "give one body a finite radius"
        else:
            reason = f"1/{lower:g} + 1/{upper:g} = {curvature:.4g} 1/mm"
            hint = "a concave radius must be larger than the convex radius of the other body"
        yield Conflict(
            ("geometry", upper_key if upper < 0 <= lower else lower_key),
            f"convexity lost along {axis}: {reason} (geometry.{lower_key}, geometry.{upper_key})",
            allowed=f"1/{lower_key} + 1/{upper_key} > 0",
            hint=hint,
        )


def _friction_limit(sections: Sections) -> Iterator[Conflict]:
    force, load = sections.get("force"), sections.get("load")
    if force is None or load is None:
        return
    prescribed = math.hypot(force.longitudinal_N or 0.0, force.lateral_N or 0.0)
    limit = load.friction_coefficient * load.normal_N
    if prescribed and prescribed >= limit:
        key = "longitudinal_N" if force.longitudinal_N is not None else "lateral_N"
        yield Conflict(
            ("force", key),
            f"the tangential force of {prescribed:.6g} N reaches or exceeds what friction can carry, "
            f"{load.friction_coefficient:g} · {load.normal_N:g} N = {limit:.6g} N",
            allowed="a force below load.friction_coefficient · load.normal_N",
        )


def _thermal_constants(sections: Sections) -> Iterator[Conflict]:
    if "material" not in sections or "thermal" not in sections or not heat_is_on(sections):
        return
    asked = "heat is on" if sections["thermal"] is not None else "the other thermal constants are given"
    for path, material in _materials(sections):
        missing = [key for key in THERMAL_CONSTANTS if getattr(material, key) is None]
        if missing:
            yield Conflict(
                path,
                f"{asked}, but missing: {', '.join(missing)}",
                allowed=f"all of {', '.join(THERMAL_CONSTANTS)}, or none of them and no heat",
                hint="a mechanical case has heat = false in [thermal], or neither [thermal] nor thermal constants",
            )


def _bulk_temperatures(sections: Sections) -> Iterator[Conflict]:
    thermal = sections.get("thermal")
    if thermal is None or thermal.partition == "matched":
        return
    lower, upper = thermal.bulk_temperature_lower_K, thermal.bulk_temperature_upper_K
    if lower != upper:
        yield Conflict(
            ("thermal", "bulk_temperature_upper_K" if upper else "bulk_temperature_lower_K"),
            f"bulk temperatures of {lower:g} K and {upper:g} K drive heat through the contact, which takes a matched partition",
            allowed='equal bulk temperatures, or partition = "matched" in [thermal]',
            other=("thermal", "partition"),
        )


def _recirculation(sections: Sections) -> Iterator[Conflict]:
    thermal, geometry = sections.get("thermal"), sections.get("geometry")
    if thermal is None:
        return
    for body in ("lower", "upper"):
        table, key = getattr(thermal, body), f"{body}_radius_x_mm"
        if table is None:
            continue
        if not table.recirculate:
            yield from _without_effect(("thermal", body), table)
            continue
        yield from _cooling(("thermal", body), table)
        if thermal.peclet != "rolling":
            yield Conflict(("thermal", "peclet"), f"a body that turns carries its heat along: not as {thermal.peclet} sources",
                           allowed='"rolling", or recirculate = false', other=("thermal", body, "recirculate"))
        if geometry is not None and math.isinf(getattr(geometry, key)):
            yield Conflict(("thermal", body, "recirculate"), "a body straight along rolling never brings its track back",
                           allowed=f"false, or a finite geometry.{key}", other=("geometry", key))
        elif geometry is not None and getattr(geometry, key) < 0.0 and table.convection_W_m2K is not None:
            yield Conflict(("thermal", body, "convection_W_m2K"),
                           "a concave body is a ring, of which only the bore is known: not where it is cooled",
                           allowed="thermal_resistance_K_W instead", other=("geometry", key))
        elif geometry is not None:
            yield from _track(sections, body, table)


def _without_effect(path: KeyPath, table: RecirculationTable) -> Iterator[Conflict]:
    """Keys of a body that turns and cools, which does neither: forgotten, unless it is switched off in so many words."""
    if "recirculate" in table.model_fields_set:
        return
    for key in sorted(table.model_fields_set):
        yield Conflict((*path, key), "has no effect on a body that brings no heat back",
                       allowed="recirculate = true beside it, or recirculate = false to keep it switched off",
                       hint="without recirculate every pass meets a cold body")


def _cooling(path: KeyPath, table: RecirculationTable) -> Iterator[Conflict]:
    given = [key for key in ("convection_W_m2K", "thermal_resistance_K_W") if getattr(table, key) is not None]
    if len(given) == 2:
        yield Conflict((*path, given[1]), f"cannot be given together with {'.'.join(map(str, path))}.{given[0]}",
                       allowed="convection, or a thermal resistance, of each body", other=(*path, given[0]))
    elif not given:
        yield Conflict((*path, "recirculate"), "a body that turns must be cooled, or it gets hotter without end",
                       allowed="one of convection_W_m2K and thermal_resistance_K_W beside it")


def _track(sections: Sections, body: str, table: RecirculationTable) -> Iterator[Conflict]:
    """The contact must fit on the body, and the body must turn."""
    creepage, radius = sections.get("creepage"), abs(getattr(sections["geometry"], f"{body}_radius_x_mm"))
    slip = 0.0 if creepage is None or creepage.longitudinal is None else creepage.longitudinal
    if 1.0 + (0.5 if body == "lower" else -0.5) * slip <= 0.0:
        yield Conflict(("creepage", "longitudinal"), f"the {body} body stands still or turns backwards at this creepage",
                       allowed="between -2 and 2 where a body brings heat back", other=("thermal", body, "recirculate"))
    contact = _contact_width(sections)
    width = 2.0 * radius if table.width_mm is None else table.width_mm
    if contact is not None and width < contact:
        yield Conflict(("thermal", body, "width_mm"), f"a width of {width:g} mm is below that of the contact, {contact:.4g} mm",
                       allowed=f"at least {contact:.4g} mm")


def _contact_width(sections: Sections) -> float | None:
    """Width 2b of Hertz's contact in mm; None where the keys that it takes are not valid."""
    if not {"geometry", "load", "material"} <= sections.keys() or any(_convexity(sections)):
        return None

    g = sections["geometry"]
    if g.lower_radius_y_mm is None or g.upper_radius_y_mm is None:
        # A profile: its contact is only known by solving for it, when the case is planned.
        return None
    curvature = (1.0 / g.lower_radius_x_mm + 1.0 / g.upper_radius_x_mm, 1.0 / g.lower_radius_y_mm + 1.0 / g.upper_radius_y_mm)
    materials = [material for _, material in _materials(sections)] * 2
    compliance = sum((1.0 - m.poisson_ratio**2) / (m.youngs_modulus_GPa * 1e3) for m in materials[:2])
    return contact_width(curvature, 1.0 / compliance, sections["load"].normal_N)


def _subsurface(sections: Sections) -> Iterator[Conflict]:
    subsurface = sections.get("subsurface")
    if subsurface is None:
        return
    if len(set(subsurface.bodies)) < len(subsurface.bodies):
        yield Conflict(("subsurface", "bodies"), "names a body twice", allowed='["lower"], ["upper"] or ["lower", "upper"]')
    if not subsurface.thermal or "thermal" not in sections or "material" not in sections:
        return
    thermal = sections["thermal"]
    if not heat_is_on(sections):
        yield Conflict(
            ("subsurface", "thermal"), "there is no heat that could make thermal stresses",
            allowed="false, or a case with heat",
            hint="heat takes conductivity_W_mK, expansion_um_mK and diffusivity_mm2_s of the material, and no heat = false",
            other=("thermal", "heat") if thermal is not None else (),
        )
    elif thermal is not None and thermal.peclet == "sliding":
        yield Conflict(
            ("subsurface", "thermal"), 'thermal stresses are not computed with peclet = "sliding" in [thermal]',
            allowed='false, or peclet = "rolling" or "stationary"', other=("thermal", "peclet"),
        )


def _materials(sections: Sections) -> Iterator[tuple[KeyPath, MaterialTable]]:
    material = sections.get("material")
    if isinstance(material, TwoMaterials):
        yield ("material", "lower"), material.lower
        yield ("material", "upper"), material.upper
    elif isinstance(material, MaterialTable):
        yield ("material",), material
