"""Names, units and meanings of what is computed below the surface."""

from __future__ import annotations

from thermoroll_cli.problem.problem import BODIES, SubsurfaceRequest

STRESSES = ("stress_xx", "stress_yy", "stress_zz", "stress_xy", "stress_xz", "stress_yz")

SUBSURFACE_FIELDS: dict[str, tuple[str, str]] = {
    "von_mises": ("Pa", "von Mises stress"),
    "von_mises_elastic": ("Pa", "von Mises stress without thermal stresses"),
    "temperature_rise": ("K", "temperature rise"),
    "stress_xx": ("Pa", "normal stress along x"),
    "stress_yy": ("Pa", "normal stress along y"),
    "stress_zz": ("Pa", "normal stress along z"),
    "stress_xy": ("Pa", "shear stress xy"),
    "stress_xz": ("Pa", "shear stress xz, z into the body"),
    "stress_yz": ("Pa", "shear stress yz, z into the body"),
}
"""Fields of one body, with SI unit and long name; tension is positive, z points into the body."""

_QUANTITIES = {
    "von_mises_max_{}_MPa": "largest von Mises stress",
    "von_mises_depth_{}_mm": "its depth",
    "von_mises_x_{}_mm": "its place along x",
    "von_mises_y_{}_mm": "its place along y",
    "orthogonal_shear_range_max_{}_MPa": "largest range of σ_xz along a line of rolling",
    "orthogonal_shear_range_depth_{}_mm": "its depth",
    "tensile_stress_max_{}_MPa": "largest first principal stress",
}

SUBSURFACE_SCALARS: dict[str, str] = {
    f"{prefix}{name.format(body)}": f"{meaning}{without}, {body} body"
    for body in BODIES
    for prefix, without in (("", ""), ("elastic_", " without thermal stresses"))
    for name, meaning in _QUANTITIES.items()
}
"""Scalars of both bodies, in the units of their names, in the order they are reported."""


def scalars_below(request: SubsurfaceRequest | None) -> tuple[str, ...]:
    """The `SUBSURFACE_SCALARS` of the bodies that are to be looked into."""
    bodies = () if request is None else request.bodies
    return tuple(name for name in SUBSURFACE_SCALARS if any(f"_{body}_" in name for body in bodies))
