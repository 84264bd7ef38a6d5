"""Tables of creep forces: their axes, the solved values and their errors, as HDF5 files that open in xarray, and as CSV."""

from __future__ import annotations

import itertools
import math
import os
from dataclasses import dataclass, field

import numpy as np

from thermoroll_cli.exact.kalker import creepage_coefficients
from thermoroll_cli.files.csv_table import write_rows
from thermoroll_cli.files.result.labelled import Labelled, Node, ResultFileError, axis, load, save
from thermoroll_cli.studies.creep_table.point_solver import QUANTITIES
from thermoroll_cli.studies.creep_table.scaling import LAW, directions, magnitude, plane_angle, scales, spin_angle
from thermoroll_cli.tools.arrays import Array

LARGEST_MAGNITUDE = 1e4
"""Stands for full sliding, u = 1: the remaining elastic creep is of the order of its inverse."""

DEFAULT_ASPECTS = (0.05, 0.075, 0.11, 0.155, 0.21, 0.27, 0.33, 0.39, 0.455, 0.53, 0.615, 0.84, 1.0, 1.42, 2.2, 3.6, 5.0, 10.0,
                   20.0)
"""Closest where forces change most with a/b: around 1/2, where spin turns from hindering to helping the lateral force."""

KIND = "creep_force_table"
RESOLUTION = 2.0**-15
"""Resolution of stored forces over μW: a twentieth of the errors of a table."""
DIMENSIONS = ("aspect_ratio", "magnitude", "direction", "spin_direction")
LONG_NAMES = {
    "force_x": "F_x/(μW)",
    "force_y": "F_y/(μW)",
    "spin_moment": "M_z/(μW sqrt(ab))",
    "stick_fraction": "stick area / contact area",
    "solver_error": "estimated error of the forces over μW",
}


@dataclass(frozen=True)
class TableAxes:
    """`aspect_ratios` a/b, increasing; numbers of evenly spaced `magnitudes` u, `directions` v and `spins` w (`scaling`)."""

    aspect_ratios: tuple[float, ...] = DEFAULT_ASPECTS
    magnitudes: int = 25
    directions: int = 13
    spins: int = 41

    def __post_init__(self) -> None:
        ratios = self.aspect_ratios
        if not ratios or not all(math.isfinite(r) and r > 0.0 for r in ratios):
            raise ValueError(f"aspect ratios a/b must be positive and finite, got {_listed(ratios)}")
        if any(later <= earlier for earlier, later in itertools.pairwise(ratios)):
            raise ValueError(f"aspect ratios a/b must increase, got {_listed(ratios)}")
        for name in ("magnitudes", "directions", "spins"):
            if getattr(self, name) < 5:  # for a cubic spline with free ends
                raise ValueError(f"at least 5 {name} are needed, got {getattr(self, name)}")
        if self.spins % 2 == 0:
            raise ValueError(f"the number of spins must be odd, so that no spin is among them, got {self.spins}")

    @property
    def shape(self) -> tuple[int, int, int]:
        """Shape of the values of one ellipse."""
        return self.magnitudes, self.directions, self.spins

    @property
    def points(self) -> int:
        """To be solved for one ellipse: not those without creepage."""
        return (self.magnitudes - 1) * self.directions * self.spins

    @property
    def u(self) -> Array:
        return np.linspace(0.0, 1.0, self.magnitudes)

    @property
    def v(self) -> Array:
        return np.linspace(0.0, 1.0, self.directions)

    @property
    def w(self) -> Array:
        return np.linspace(-1.0, 1.0, self.spins)

    def scaled(self, first: int, last: int) -> Array:
        """(X, Y, Z) of the points first … last − 1 of one ellipse, (3, n)."""
        with np.errstate(divide="ignore"):
            sizes = np.minimum(magnitude(self.u[1:-1]), LARGEST_MAGNITUDE)
        sizes = np.append(sizes, LARGEST_MAGNITUDE)
        level, v, w = np.unravel_index(np.arange(first, last), (self.magnitudes - 1, self.directions, self.spins))
        return np.asarray(sizes[level] * directions(self.v[v], self.w[w]))


@dataclass(frozen=True)
class Quality:
    """Errors of forces over μW: those of the solver, estimated over all points, and differences between table and solver at
    `points` random ones that are not in the table (nan: not measured)."""

    solver_rms: float = math.nan
    solver_max: float = math.nan
    points: int = 0
    rms: float = math.nan
    largest: float = math.nan


@dataclass(frozen=True)
class TableValues:
    """`values` (ellipses, 4, magnitudes, directions, spins) of `QUANTITIES`, nan where a point has no solution (a hole);
    `errors` of the forces, the same without the quantities; Poisson's ratio and the accuracy that was asked for."""

    axes: TableAxes
    poisson_ratio: float
    accuracy: float
    values: Array
    errors: Array
    quality: Quality = field(default_factory=Quality)

    @property
    def holes(self) -> int:
        return int(np.isnan(self.values[:, 0]).sum())


def _listed(values: tuple[float, ...]) -> str:
    return ", ".join(f"{value:g}" for value in values) or "none"


def write_table(path: str | os.PathLike[str], table: TableValues, *, command_line: str) -> None:
    """Write `table` to `path`, complete or not at all. Raises WriteError."""
    axes = table.axes
    nodes = (np.array(axes.aspect_ratios), axes.u, axes.v, axes.w)
    meanings = ("a/b, a along rolling", "u of the magnitude m", "v of the angle alpha", "w of the spin angle beta")
    arrays = {key: array for name, values, meaning in zip(DIMENSIONS, nodes, meanings, strict=True)
              for key, array in axis(name, values, "1", meaning).items()}
    columns = dict(zip(QUANTITIES, np.moveaxis(table.values, 1, 0), strict=True)) | {"solver_error": table.errors}
    # Zeros behind the digits that matter: half the size when compressed. Towards zero, so that forces keep the bound.
    arrays |= {name: Labelled(DIMENSIONS, (np.trunc(values / RESOLUTION) * RESOLUTION).astype(np.float32), "1",
                              LONG_NAMES[name], compressed=True) for name, values in columns.items()}
    save(path, Node(arrays, {"scaling": LAW, "poisson_ratio": table.poisson_ratio, "accuracy": table.accuracy,
                             "holes": table.holes,
                             **{f"quality_{name}": value for name, value in vars(table.quality).items()}}), KIND, command_line)


def read_table(path: str | os.PathLike[str]) -> TableValues:
    """The table at `path`. Raises ResultFileError: missing, foreign, cut short, damaged, of another version, or with axes that
    do not increase."""
    tree = load(path, KIND)
    try:
        if (scaling := tree.attributes["scaling"]) != LAW:
            raise ResultFileError(f"{path}: table of scaling {scaling}; this version reads {LAW}: build it again with "
                                  "thermoroll table")
        ratios, u, v, w = (tree.arrays[name].values for name in DIMENSIONS)
        axes = TableAxes(tuple(ratios.tolist()), len(u), len(v), len(w))
        for name, stored, own in zip(DIMENSIONS[1:], (u, v, w), (axes.u, axes.v, axes.w), strict=True):
            if not np.allclose(stored, own, atol=1e-12):
                raise ValueError(f"the axis {name} does not increase evenly")
        values = np.stack([tree.arrays[name].values.astype(float) for name in QUANTITIES], axis=1)
        errors = tree.arrays["solver_error"].values.astype(float)
        if values.shape != (len(ratios), len(QUANTITIES), *axes.shape) or errors.shape != (len(ratios), *axes.shape):
            raise ValueError("values and axes have different lengths")
        quality = {name: float(tree.attributes[f"quality_{name}"]) for name in vars(Quality())}
        poisson_ratio, accuracy = (float(tree.attributes[name]) for name in ("poisson_ratio", "accuracy"))
    except (KeyError, ValueError, TypeError, AttributeError) as cause:
        raise ResultFileError(f"{path}: damaged {KIND} file ({cause.args[0] if cause.args else cause})") from cause
    return TableValues(axes, poisson_ratio, accuracy, values, errors,
                       Quality(**(quality | {"points": int(quality["points"])})))  # type: ignore[arg-type]


def write_csv(path: str | os.PathLike[str], table: TableValues) -> None:
    """A line per point, with its scaled creepages; holes are empty. Raises WriteError."""
    axes = table.axes
    sizes, unit = np.append(magnitude(axes.u[:-1]), math.inf), directions(axes.v[:, None], axes.w[None])[:, None]
    with np.errstate(invalid="ignore"):
        scaled = np.where(unit == 0.0, 0.0, unit * sizes[:, None, None])
    angles = (np.degrees(plane_angle(axes.v)), np.degrees(spin_angle(axes.w)))
    places = np.meshgrid(sizes, *angles, indexing="ij")
    rows: list[list[str]] = []
    for values, ratio in zip(table.values, axes.aspect_ratios, strict=True):
        per = np.array(scales(creepage_coefficients(ratio, table.poisson_ratio)))
        constant = [np.full(axes.shape, number) for number in (ratio, *per)]
        columns = [constant[0], *(scaled / per[:, None, None, None]), *places, *constant[1:], *values]
        rows += [["" if math.isnan(cell) else f"{cell:.7g}" for cell in cells]
                 for cells in np.stack(columns, axis=-1).reshape(-1, len(columns))]
    header = ["aspect_ratio", "xi", "eta", "phi", "magnitude", "alpha_deg", "beta_deg", "magnitude_per_xi",
              "magnitude_per_eta", "magnitude_per_phi", *QUANTITIES]  # fmt: skip
    write_rows(path, header, rows)
