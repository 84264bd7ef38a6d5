"""What must hold of transverse profiles, alone and against the other body."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from thermoroll_cli.contact.contact_scales import contact_scales
from thermoroll_cli.files.case.case_model import PROFILES, GeometryTable, ProfileTable, Settings
from thermoroll_cli.files.case.profile_file import point_fault, profile_of
from thermoroll_cli.problem.problem import Geometry

CROWN = ("length_mm", "drop_um", "flat_mm")
SOURCES = ("points_mm", "file", "kind")


RELIEVE = ('of a measured profile give more; of a roller relieve the ends, by a crown (kind = "logarithmic") or by points that '
           "fall off: at sharp ends the pressure has no limit")


@dataclass(frozen=True)
class Fault:
    """`key` of the table at which the message stands; empty: the table itself."""

    key: str
    message: str
    allowed: str = ""
    hint: str = ""


def profile_faults(table: ProfileTable) -> Iterator[Fault]:
    """What is wrong with a profile by itself."""
    given = [key for key in SOURCES if getattr(table, key) is not None]
    if len(given) != 1:
        what = f"{' and '.join(given)} exclude each other" if given else "has neither points_mm nor file nor kind"
        yield Fault(given[-1] if given else "", what, "one of points_mm, file and kind")
        return
    if table.kind is None:
        yield from (Fault(key, "belongs to a crown, with kind", "one of points_mm, file and kind") for key in CROWN
                    if getattr(table, key) is not None)
    else:
        yield from (Fault("kind", f"a crown needs {key}", "length_mm and drop_um with kind") for key in CROWN[:2]
                    if getattr(table, key) is None)
        if table.length_mm is not None and table.flat_mm is not None and table.flat_mm >= table.length_mm:
            yield Fault("flat_mm", "the flat part is as long as the crown", f"less than length_mm = {table.length_mm:g}")
    for k in range(len(table.points_mm or ())):
        assert table.points_mm is not None
        if fault := point_fault(table.points_mm, k):
            yield Fault("points_mm", f"point {k + 1}: {fault}", "pairs [y, height] with y increasing")
            return


def touching(settings: Settings) -> Fault | None:
    """What keeps the bodies of a valid case with profiles from a contact that can be solved; None without profiles."""
    geometry = settings.geometry
    bodies = [body for body in PROFILES if getattr(geometry, body) is not None]
    if not bodies:
        return None
    profiles = geometry_si(geometry)
    for body in bodies:
        low, high = getattr(profiles, body).ends
        if settings.rolling.differential_slip and not low < 0.0 < high:
            return Fault(body, f"has no material at y = 0, from where differential slip is measured: it reaches from "
                         f"{1e3 * low:g} to {1e3 * high:g} mm",
                         "a profile around y = 0, or differential_slip = false in [rolling]")

    moduli = [m.youngs_modulus_GPa * 1e9 / (1.0 - m.poisson_ratio**2) for m in settings.materials.values()]
    try:
        contact_scales(profiles, 1.0 / (1.0 / moduli[0] + 1.0 / moduli[1]), settings.load.normal_N)
    except ValueError as cause:
        return Fault(bodies[-1], str(cause), "profiles that touch, and are longer than their contact on one side at least",
                     hint=RELIEVE if "both ends" in str(cause) else "")
    return None


def geometry_si(geometry: GeometryTable) -> Geometry:
    """Both bodies' shapes in m; a body with a profile has no lateral radius."""
    def radius(value: float | None) -> float:
        return float("inf") if value is None else value / 1e3

    lower, upper = (None if table is None else profile_of(table) for table in (geometry.lower_profile, geometry.upper_profile))
    return Geometry(radius(geometry.lower_radius_x_mm), radius(geometry.lower_radius_y_mm),
                      radius(geometry.upper_radius_x_mm), radius(geometry.upper_radius_y_mm), lower, upper)
