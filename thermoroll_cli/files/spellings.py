"""What people write in place of our keys and units: words for which a message names the key, and units behind the names of a
table's columns, from which numbers are converted."""

from __future__ import annotations

import math
import re
import unicodedata
from collections.abc import Sequence

from thermoroll_cli.files.case_schema import entry_at
from thermoroll_cli.files.case_source import key_path
from thermoroll_cli.files.case_table import SI, quantity_of
from thermoroll_cli.problem.names import ALL_SCALARS, ERROR, unit_of
from thermoroll_cli.problem.names import UNITS as UNITS_OF_NAMES

WORDS = {
    "creepage.longitudinal": "srr sliderollratio slidetorollratio slip slipratio longitudinalslip slippage creep creepage "
                             "longitudinalcreepage ξ ξx xi xix",
    "creepage.spin_rad_mm": "spin spincreepage φ phi ψ psi",
    "load.normal_N": "normalload normalforce load force fn fz w",
    "load.friction_coefficient": "μ mu cof friction coefficientoffriction frictioncoeff tractioncoefficient",
    "rolling.speed_m_s": "v u speed velocity rollingspeed rollingvelocity entrainmentspeed meanspeed",
    "material.youngs_modulus_GPa": "e emodulus youngsmodulus youngmodulus elasticmodulus modulus",
    "material.poisson_ratio": "ν nu poisson poissonsratio",
    "material.conductivity_W_mK": "k λ lambda thermalconductivity",
    "material.expansion_um_mK": "α alpha cte thermalexpansion",
    "material.relaxation_file": "tanδ tandelta tand lossfactor storagemodulus lossmodulus e' e''",
    "material.density_kg_m3": "ρ rho",
}
"""Keys, and words for them in small letters, without spaces and signs between."""

UNITS = SI | {
    "%": ("", 1e-2), "‰": ("", 1e-3), "kN": ("N", 1e3), "MN": ("N", 1e6), "lbf": ("N", 4.4482216152605), "kPa": ("Pa", 1e3),
    "N/mm²": ("Pa", 1e6), "kN/mm²": ("Pa", 1e9), "nm": ("m", 1e-9), "cm": ("m", 1e-2), "in": ("m", 25.4e-3),
    "km/h": ("m/s", 1 / 3.6), "kmh": ("m/s", 1 / 3.6), "µm/s": ("m/s", 1e-6),
    "mW": ("W", 1e-3), "kW": ("W", 1e3), "deg": ("rad", math.pi / 180.0),
    "°": ("rad", math.pi / 180.0), "1/mm": ("rad/m", 1e3), "1/m": ("rad/m", 1.0), "ms": ("s", 1e-3), "µs": ("s", 1e-6),
    "min": ("s", 60.0), "h": ("s", 3600.0), "cm²/s": ("m²/s", 1e-4), "mm²": ("m²", 1e-6), "µm²": ("m²", 1e-12),
    "cm²": ("m²", 1e-4),
    "N mm": ("N m", 1e-3), "ppm/K": ("1/K", 1e-6), "N/mm": ("N/m", 1e3), "kN/mm": ("N/m", 1e6), "N/µm": ("N/m", 1e6),
    "W/mm²": ("W/m²", 1e6), "mm³": ("m³", 1e-9), "rpm": ("rad/s", math.pi / 30.0),
}
"""Units that people write, their SI units, and the factors to these. Units not named here are SI units."""

_IN_BRACKETS = re.compile(r"(.*?)\s*[\[(]([^\])]*)[\])]")


def meant(word: str) -> str:
    """The key for which people write `word`, with or without a unit; "" where it is no such word."""
    plain = unicodedata.normalize("NFKC", _IN_BRACKETS.sub(r"\1", word).replace("″", "''").replace("′", "'"))
    plain = re.sub(r"[\s_.%/-]", "", quantity_of(plain)).lower()
    return next((key for key, words in WORDS.items() if plain in words.split() or plain.replace("'", "") in words.split()), "")


def unit_in(word: str) -> str:
    """The unit at the end of a key that somebody has written, as `UNITS` has it; "" where it has none."""
    if found := _IN_BRACKETS.fullmatch(word.strip()):
        return _plain(found[2])
    end = word.strip()[len(quantity_of(word.strip())):].lstrip("_")
    return "%" if word.strip().endswith("%") else _plain(end.replace("_", "/"))


def converted(value: float, factor: float) -> float:
    """`value` in another unit, as a table would say it: 0.7 % are 0.007, and not 0.00699…9."""
    return float(f"{value * factor:.14g}")


def factor_of(written: str, own: str) -> float | None:
    """What a number in the unit `written` is multiplied by to be one in the unit `own`; None where that is another quantity."""
    (si, factor), (own_si, own_factor) = (UNITS.get(_plain(unit), (_plain(unit), 1.0)) for unit in (written, own))
    return factor / own_factor if si == own_si else None


def _plain(unit: str) -> str:
    """A unit in the letters of `UNITS`."""
    plain = re.sub(r"(?<![a-z])u(?=[ms])", "µ", unit.strip().replace("μ", "µ").replace("·", " "))
    plain = re.sub(r"(?<=m)\^?([23])", lambda power: {"2": "²", "3": "³"}[power[1]], plain)
    return {"-": "", "–": "", "1": "", "percent": "%"}.get(plain, plain)


def _completed(name: str, unit: str) -> str:
    """The key or the scalar that is called `name` but for its unit, and may be in `unit`; `name` itself where there is none."""
    bare = name.removesuffix(ERROR)
    ends = ("", *(end for end, own in UNITS_OF_NAMES.items() if factor_of(unit, own) is not None))
    known = (whole for end in ends if (whole := bare + end) in ALL_SCALARS or entry_at(key_path(whole)))
    return next(known, bare) + name[len(bare):]


def in_own_units(source: str, names: Sequence[str]) -> tuple[list[str], list[float]]:
    """The names of columns without the units in brackets behind them, which may stand in place of those at the end of a name,
    and the factors to the units that names say. Raises ValueError for a unit of another quantity."""
    plain, factors = list[str](), list[float]()
    for name in names:
        found = _IN_BRACKETS.fullmatch(name.strip())
        bare = _completed(found[1], found[2]) if found else name
        own = unit_of(bare.removesuffix(ERROR))
        factor = factor_of(found[2], own) if found else 1.0
        if factor is None:
            kin = [unit for unit, (si, _) in UNITS.items() if si == UNITS.get(own, (own, 1.0))[0] and unit != own]
            others = f", {', '.join(kin)}" if kin else ""
            if (key := meant(bare)) and key != bare:
                raise ValueError(f"{source}: the column {name} is no key: did you mean {key} [{found[2] if found else ''}]?")
            raise ValueError(f"{source}: the column {name} cannot be in {found[2] if found else ''}; {bare} is "
                             f"in {own or 'numbers without a unit'}{others}")
        plain.append(bare)
        factors.append(factor)
    return plain, factors
