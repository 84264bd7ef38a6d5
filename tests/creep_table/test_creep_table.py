"""Tables of creep forces: against the solver, CONTACT and Kalker; built, stopped, resumed, refused."""

from __future__ import annotations

import io
import json
import math
import re
import time
from collections.abc import Callable, Iterator
from contextlib import redirect_stdout
from dataclasses import replace
from pathlib import Path
from unittest import mock

import h5py
import numpy as np
import pytest
import xarray

from tests.support.command_line import call
from tests.support.documents import cell, printed
from tests.support.sampling import sampled
from tests.support.scenes import CASES, elastic, ellipse, reference, rolling
from thermoroll_cli import CreepForceTable
from thermoroll_cli.exact.kalker import creepage_coefficients
from thermoroll_cli.files.result.labelled import ResultFileError
from thermoroll_cli.one_contact.steady_state.derived import DerivedQuantities
from thermoroll_cli.problem.friction import Friction, FrictionLaw
from thermoroll_cli.problem.geometry import Geometry
from thermoroll_cli.problem.problem import Heating, Material, Motion, Numerics, Problem
from thermoroll_cli.python_api import Solver, solve
from thermoroll_cli.studies.creep_table.build import TablePlan, build_table, journal_path
from thermoroll_cli.studies.creep_table.creep_force_table import DEFAULT_TABLE, OutsideTable, fill_holes
from thermoroll_cli.studies.creep_table.point_solver import EllipseSolver
from thermoroll_cli.studies.creep_table.table_file import RESOLUTION, TableAxes, read_table, write_table
from thermoroll_cli.tools.journal import JournalError
from thermoroll_cli.tools.runner import Workers

ROOT = Path(__file__).parents[2]
CIRCLE = ROOT / "cases" / "creep_forces_circle.h5"
"""`thermoroll table build --aspect 1`: one ellipse of the default table."""
STEEL = {"shear_modulus": 82e9, "friction": 0.3, "load": 8e4}
TINY = ("--aspect", "1", "--accuracy", "1e-2", "--nodes", "5,5,5")
RNG = np.random.default_rng(11)


@pytest.fixture(scope="module")
def circle() -> CreepForceTable:
    return CreepForceTable.read(CIRCLE)


@pytest.fixture(scope="module", autouse=True)
def shipped() -> Iterator[CreepForceTable]:
    """The table that comes with the program, read once."""
    table = CreepForceTable.default()
    with mock.patch.object(CreepForceTable, "default", lambda: table):
        yield table


@pytest.fixture(scope="module")
def tiny(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("table") / "tiny.h5"
    assert call("table", "build", *TINY, "-o", path, "--checks", "10", "-q").returncode == 0
    return path


# --- how good it is ------------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_states_errors_within_the_goals(circle: CreepForceTable) -> None:
    quality = circle.values.quality
    assert quality.points == printed("sweeps_and_tables", "1,000 random points")[0].value
    assert circle.values.holes == 0
    assert_quality_is_printed(circle, "a/b = 1")


def assert_quality_is_printed(table: CreepForceTable, row: str) -> None:
    rms, largest = cell("sweeps_and_tables", row, "difference: rms, largest")
    assert table.values.quality.rms == pytest.approx(rms.value, abs=rms.rounding)
    assert table.values.quality.largest == pytest.approx(largest.value, abs=largest.rounding)
    (points,) = cell("sweeps_and_tables", row, "points")
    axes = table.values.axes
    # Nothing is solved at u = 0, and both ends of w are one.
    assert len(axes.aspect_ratios) * (axes.magnitudes - 1) * axes.directions * (axes.spins - 1) == points.value


def test_is_what_the_solver_finds(circle: CreepForceTable) -> None:
    """At creepages that are no nodes, so that a stale file would show."""
    solver = EllipseSolver(1.0, circle.values.poisson_ratio)
    creepages = RNG.uniform(-1.5, 1.5, (3, 12)) / np.array(solver.scales)[:, None]
    direct, _ = solver.solve(creepages)
    found = circle.forces(*creepages, semi_axes=(1.0, 1.0), shear_modulus=1.0, friction=1.0, load=1.0)
    np.testing.assert_allclose(found.force_x, direct[0], atol=4e-3)
    np.testing.assert_allclose(found.force_y, direct[1], atol=4e-3)
    np.testing.assert_allclose(found.spin_moment, direct[2], atol=5e-3)
    np.testing.assert_allclose(found.stick_fraction, direct[3], atol=5e-2)


@pytest.mark.parametrize("aspect_ratio", sampled([0.2, 3.0]))
def test_forces_are_those_of_single_runs(aspect_ratio: float) -> None:
    """On the same grid, to a hundredth of the discretisation error."""
    solver = EllipseSolver(aspect_ratio, 0.28, accuracy=4e-3)
    grid = solver._grids[1]
    creepages = RNG.uniform([[0.0], [0.0], [-1.0]], [[1.0], [1.0], [1.0]], (3, 6)) / np.array(solver.scales)[:, None]
    creepages *= np.array([0.2, 0.5, 1.0, 2.0, 5.0, 30.0])
    solved = [grid.solve(creepage) for creepage in creepages.T]
    assert all(solution.converged for _, solution in solved)
    base = rolling(grid=grid.grid.shape, geometry=ellipse(aspect_ratio), body=elastic(0.28), load=100.0)
    limit, single = base.traction_limit, Solver()
    hertz = single.solve(base).of_problem
    a, b = hertz["hertz_a_mm"] * 1e-3, hertz["hertz_b_mm"] * 1e-3
    unit = limit / (base.lower.shear_modulus * a * b)
    for (x, y, z), ((force_x, force_y, _, stick), _) in zip(creepages.T, solved, strict=True):
        motion = Motion(1.0, x * unit, y * unit, z * unit / np.sqrt(a * b), differential_slip=False)
        result = single.solve(replace(base, motion=motion))
        shear = np.array([result.isothermal.fields["shear_x"], result.isothermal.fields["shear_y"]])
        total = shear.sum(axis=(1, 2)) * (result.x[1] - result.x[0]) * (result.y[1] - result.y[0]) / limit
        np.testing.assert_allclose((force_x, force_y), total, atol=2e-5)
        assert stick == pytest.approx(result.isothermal.scalars["gamma_st"], abs=2e-3)


@pytest.mark.parametrize("case", CASES)
def test_against_contact(case: str, circle: CreepForceTable) -> None:
    stored = reference("contact_rolling")["cases"][case]
    given, other = stored["input"], stored["extrapolated"]
    a, limit = stored["hertz"]["a_mm"] * 1e-3, given["friction_coefficient"] * given["normal_N"]
    found = circle.forces(
        given["creepage_longitudinal"], given["creepage_lateral"], given["spin_rad_mm"] * 1e3, semi_axes=(a, a),
        shear_modulus=given["youngs_modulus_GPa"] * 1e9 / (2.0 * (1.0 + given["poisson_ratio"])),
        friction=given["friction_coefficient"], load=given["normal_N"])  # fmt: skip
    assert float(found.force_x) == pytest.approx(other["force_x_N"], abs=3e-3 * limit)
    assert float(found.force_y) == pytest.approx(other["force_y_N"], abs=3e-3 * limit)
    assert float(found.spin_moment) * 1e3 == pytest.approx(other["spin_moment_Nmm"], abs=5e-3 * limit * a * 1e3)
    assert float(found.t_gamma) == pytest.approx(other["dissipation_from_forces_W"], rel=1e-2)


def test_slopes_at_zero_are_kalkers(circle: CreepForceTable) -> None:
    c = creepage_coefficients(1.0, circle.values.poisson_ratio)
    small = 1e-6
    found = circle.forces(*(small * np.eye(3)), semi_axes=(1.0, 1.0), shear_modulus=1.0, friction=1.0, load=1.0)
    np.testing.assert_allclose(found.force_x / small, [c.c11, 0.0, 0.0], rtol=5e-3, atol=1e-6)
    np.testing.assert_allclose(found.force_y / small, [0.0, c.c22, -c.c23], rtol=5e-3, atol=1e-6)
    np.testing.assert_allclose(found.spin_moment / small, [0.0, c.c23, c.c33], rtol=5e-3, atol=1e-6)


def test_never_above_the_bound_and_monotone_without_spin(circle: CreepForceTable) -> None:
    creepages = RNG.normal(size=(3, 20_000)) * 10.0 ** RNG.uniform(-3, 3, 20_000)
    found = circle.forces(*creepages, semi_axes=(1.0, 1.0), shear_modulus=1.0, friction=1.0, load=1.0)
    assert np.hypot(found.force_x, found.force_y).max() <= 1.0 + 1e-15
    assert (found.t_gamma >= 0.0).all()
    size = np.linspace(0.0, 5.0, 2000)
    for angle in np.radians([0.0, 20.0, 45.0, 70.0, 90.0]):
        pure = circle.forces(size * math.cos(angle), size * math.sin(angle), 0.0, semi_axes=(1.0, 1.0), shear_modulus=1.0,
                             friction=1.0, load=1.0)  # fmt: skip
        total = np.hypot(pure.force_x, pure.force_y)
        assert (np.maximum.accumulate(total) - total).max() < 2e-5
        assert total[-1] == pytest.approx(1.0, abs=2e-3)


def test_what_slides_never_sticks_again(shipped: CreepForceTable) -> None:
    """Along creepages without spin in one proportion γ_st falls to 0 and stays there; the splines of the shipped table
    swing about that kink."""
    size = np.linspace(0.0, 0.02, 801)
    for axes in ((5.5e-3, 5.2e-3), (3e-3, 7e-3)):
        for lateral in (0.0, 0.3, 1.0):
            stick = shipped.forces(size, lateral * size, 0.0, semi_axes=axes, **STEEL).stick_fraction
            assert np.diff(stick).max() == 0.0 == stick[-1] and stick[0] == pytest.approx(1.0)


def test_reversal_mirror_and_units(circle: CreepForceTable) -> None:
    creepages = RNG.normal(size=(3, 50)) * 1e-3 * np.array([[1.0], [1.0], [200.0]])
    contact = {"semi_axes": (5e-3, 5e-3), **STEEL}
    found = circle.forces(*creepages, **contact)
    back, mirror = circle.forces(*-creepages, **contact), circle.forces(creepages[0], *-creepages[1:], **contact)
    for name, reflected in (("force_x", 1.0), ("force_y", -1.0), ("spin_moment", -1.0)):
        own = getattr(found, name)
        np.testing.assert_allclose(getattr(back, name), -own, atol=1e-9 * np.abs(own).max())
        np.testing.assert_allclose(getattr(mirror, name), reflected * own, atol=1e-9 * np.abs(own).max())
    double = circle.forces(*creepages, semi_axes=(5e-3, 5e-3), shear_modulus=82e9, friction=0.15, load=16e4)
    np.testing.assert_allclose(double.force_y, found.force_y)
    assert found.force_x.shape == (50,)
    assert circle.forces(1e-3, 0.0, 0.0, **contact).force_x.shape == ()


@pytest.mark.slow
def test_falling_friction_through_an_equivalent_coefficient() -> None:
    """Within the stated errors of what the solver finds: a wheel on a rail, with and without spin."""
    steel, law = Material(210e9, 0.28), FrictionLaw("exponential", 0.14 / 0.33, 1.25)
    table, nothing = CreepForceTable.default(), Heating(heat=False)
    for creepage, spin in ((0.01, 0.0), (0.003, 0.3)):
        motion = Motion(20.0, creepage, 0.0, spin, differential_slip=False)
        geometry = Geometry(0.46, math.inf, math.inf, 0.3)
        problem = Problem(steel, steel, geometry, 1e5, Friction(0.33, law), motion, nothing, Numerics(grid=(32, 32)))
        hertz, exact = DerivedQuantities(problem).hertz, solve(problem).coupled.scalars
        found = table.forces(creepage, 0.0, spin, semi_axes=(hertz.semi_axis_x, hertz.semi_axis_y), load=1e5, friction=0.33,
                             shear_modulus=steel.shear_modulus, law=law, speed=20.0)
        assert found.error < 0.15 * problem.traction_limit
        assert float(found.force_x) == pytest.approx(exact["force_x_N"], abs=float(found.error))
        assert float(found.force_y) == pytest.approx(exact["force_y_N"], abs=float(found.error))


@pytest.mark.slow
def test_a_million_look_ups_take_seconds(circle: CreepForceTable) -> None:
    """In units of what a sine of as many numbers takes, so that other work on the machine does not count."""
    creepages = RNG.normal(size=(3, 50_000))

    def least(compute: Callable[[], object]) -> float:
        """Processor time of the fastest of five: others that share the processor's memory slow single ones."""
        times = []
        for _ in range(5):
            began = time.process_time()
            compute()
            times.append(time.process_time() - began)
        return min(times)

    look_ups = least(lambda: circle.forces(*creepages, semi_axes=(1.0, 1.0), shear_modulus=1.0, friction=1.0, load=1.0))
    sines = least(lambda: [np.sin(creepages[0]) for _ in range(40)])  # 0.02 µs each
    # A look-up takes about 50 sines, 180 with NumPy 1.26; with 240 it would still be a fifth of a million of them a second.
    assert look_ups < 6.0 * sines


def test_the_simulation_of_the_documents() -> None:
    """docs/sweeps_and_tables.md, verbatim: a wheelset that finds its creepage under a brake."""
    page = (ROOT / "docs" / "sweeps_and_tables.md").read_text(encoding="utf-8")
    (script,) = [block for block in re.findall(r"```python\n(.*?)```", page, re.DOTALL) if "CreepForceTable" in block]
    with redirect_stdout(io.StringIO()) as printed:
        exec(script, {})
    creepage, force = map(float, printed.getvalue().split())
    assert 0.0 < creepage < 0.005
    assert force == pytest.approx(12e3, rel=1e-3)


# --- building ------------------------------------------------------------------------------------------------------


def test_an_array_that_xarray_opens(tiny: Path) -> None:
    with xarray.open_dataset(tiny, engine="h5netcdf") as found:
        assert dict(found.sizes) == {"aspect_ratio": 1, "magnitude": 5, "direction": 5, "spin_direction": 5}
        assert found.attrs["quality_points"] == 10
        assert 0.0 < found.attrs["quality_rms"] < 0.1
        assert float(np.hypot(found.force_x, found.force_y).max()) <= 1.0 + 1e-6


@pytest.mark.slow
def test_stopped_and_resumed_and_in_two_processes(tiny: Path, tmp_path: Path) -> None:
    plan = TablePlan(TableAxes((1.0,), 5, 5, 5), accuracy=1e-2, checks=10)
    path = tmp_path / "t.h5"

    class Stop(Exception):
        pass

    def stop(count: int, solved: bool) -> None:
        raise Stop

    with pytest.raises(Stop):
        build_table(plan, path, workers=Workers(), report=stop)
    with open(journal_path(path), "ab") as stream:
        stream.write(b'{"key": "torn')
    notes: list[str] = []
    built = build_table(plan, path, workers=Workers(jobs=2), resume=True, note=notes.append)
    assert notes == ["100 of 110 points are solved already"]
    stored = read_table(tiny)
    np.testing.assert_allclose(built.values, stored.values, atol=RESOLUTION + 1e-6)
    assert built.quality.rms == pytest.approx(stored.quality.rms, rel=1e-5)
    with pytest.raises(JournalError, match="of another table"):
        build_table(replace(plan, poisson_ratio=0.3), path, workers=Workers(), resume=True)


def test_without_a_cluster(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "t.h5"
    done = call("table", "build", *TINY, "-o", path, "--jobs", "2", "--dask", "tcp://127.0.0.1:1")
    assert (done.returncode, "the cluster decides" in done.stderr) == (2, True)
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    done = call("table", "build", *TINY, "-o", path, "--dask", "tcp://127.0.0.1:1")
    assert (done.returncode, "pip install 'thermoroll[dask]'" in done.stderr) == (2, True)
    assert list(tmp_path.iterdir()) == []


def test_holes_are_told_and_filled_from_their_neighbours(tiny: Path, tmp_path: Path) -> None:
    table = read_table(tiny)
    values = table.values.copy()
    values[0, :, 3, 2, 2:4] = np.nan
    path = tmp_path / "holes.h5"
    write_table(path, replace(table, values=values), command_line="")
    read = CreepForceTable.read(path)
    assert read.values.holes == 2
    filled = fill_holes(values[0])
    assert np.abs(filled - table.values[0]).max() < 0.2
    assert not np.isnan(filled).any()
    whole, found = (t.forces(0.3, 0.2, 0.2, semi_axes=(1.0, 1.0), shear_modulus=1.0, friction=1.0, load=1.0)
                    for t in (CreepForceTable(table), read))  # fmt: skip
    assert float(found.force_x) == pytest.approx(float(whole.force_x), abs=0.1)


def test_between_ellipses_and_many_at_once(shipped: CreepForceTable) -> None:
    ratio = np.geomspace(0.8, 1.25, 8)
    many = shipped.forces(0.2, 0.1, 0.1, semi_axes=(ratio, np.ones(8)), shear_modulus=1.0, friction=1.0, load=1.0)
    for r, force in zip(ratio, many.force_y, strict=True):
        one = shipped.forces(0.2, 0.1, 0.1, semi_axes=(float(r), 1.0), shear_modulus=1.0, friction=1.0, load=1.0)
        assert float(one.force_y) == pytest.approx(float(force), abs=1e-4)
    assert np.ptp(many.force_y) > 1e-3


def test_what_is_built_is_not_built_again(tiny: Path) -> None:
    before = tiny.stat().st_mtime_ns
    done = call("table", "build", *TINY, "-o", tiny, "--checks", "10", "--resume")
    assert (done.returncode, "is built already" in done.stderr) == (0, True)
    other = call("table", "build", *TINY, "-o", tiny, "--checks", "10", "--poisson", "0.3")
    assert other.returncode == 5 and "Poisson's ratio 0.28" in other.stderr and "Poisson's ratio 0.3," in other.stderr
    assert tiny.stat().st_mtime_ns == before


# --- the command ---------------------------------------------------------------------------------------------------


CONTACT = ("--semi-axes-mm", "5,5", "--shear-modulus-GPa", "82", "--friction", "0.3", "--normal-N", "80000")


def test_a_query_is_drawn_as_a_sweep_and_names_the_option(tiny: Path, tmp_path: Path) -> None:
    over = ("--longitudinal", "0:0.01:5", "--spin-rad-mm", "0,1e-3", *CONTACT)
    done = call("table", "query", tiny, *over, "--plot", tmp_path / "q.svg", painted=True)
    shown = (tmp_path / "q.svg").read_text()
    assert done.returncode == 0 and all(
        words in shown for words in ("spin = 0.001 rad/mm", "longitudinal creepage", "W = 80000 N"))
    for wrong in (("--plot", tmp_path / "q.gif"), ("--plot", tmp_path / "q.png", "--longitudinal", "0", "--spin-rad-mm", "0")):
        assert call("table", "query", tiny, *over, *wrong).returncode == 2
    other = call("table", "query", tiny, *over, "--plots", "all")
    assert other.returncode == 2 and "Possible options: --plot)" in other.stderr


def test_query_and_export(tiny: Path, tmp_path: Path) -> None:
    done = call("table", "query", tiny, "--longitudinal", "0:0.01:3", "--spin-rad-mm", "1e-4", *CONTACT, "--json")
    records = [json.loads(line) for line in done.stdout.splitlines()]
    printed = call("table", "query", tiny, "--longitudinal", "0:0.01:3", "--spin-rad-mm", "1e-4", *CONTACT).stdout.splitlines()
    assert [float(line.split()[0]) for line in printed[-3:]] == [0.0, 0.005, 0.01]
    assert len({line.index(" 0.0001 ") for line in printed[-3:]}) == 1 and max(map(len, printed)) < 140
    assert [record["creepage_longitudinal"] for record in records] == [0.0, 0.005, 0.01]
    assert records[-1]["force_x_N"] == pytest.approx(24_000, rel=0.05)
    table = CreepForceTable.read(tiny)
    direct = table.forces(0.005, 0.0, 0.1, semi_axes=(5e-3, 5e-3), **STEEL)
    assert records[1]["force_y_N"] == pytest.approx(float(direct.force_y))
    largest = table.values.quality.largest * 24_000
    assert records[1]["force_error_N"] == pytest.approx(largest)
    assert records[1]["spin_moment_error_Nmm"] == pytest.approx(largest * 5.0)
    assert records[1]["T_gamma_error_N"] == pytest.approx(largest * (0.005 + 1e-4 * 5.0))
    resting = table.forces([0.0, 1e-6], 0.0, 0.0, semi_axes=(5e-3, 5e-3), **STEEL)
    assert resting.error[0] == resting.t_gamma_error[0] == 0.0 < resting.error[1] < 0.1 * largest
    assert not resting.spin_moment_error.any()
    assert records[1]["poisson_ratio"] == 0.28
    csv = tmp_path / "table.csv"
    assert call("table", "query", tiny, "--csv", csv).returncode == 0
    lines = csv.read_text().splitlines()
    assert len(lines) == 1 + 5 * 5 * 5
    assert lines[0].startswith("aspect_ratio,xi,eta,phi,magnitude")
    assert call("table", "query", tiny, "--longitudinal", "0:0.01:3", *CONTACT, "--csv", csv).returncode == 0
    assert [line.split(",")[0] for line in csv.read_text().splitlines()] == ["creepage_longitudinal", "0.0", "0.005", "0.01"]


def test_the_table_that_comes_with_the_program_answers_for_any_ellipse(shipped: CreepForceTable) -> None:
    table = shipped
    assert DEFAULT_TABLE.stat().st_size <= 3_000_000
    ratios = table.values.axes.aspect_ratios
    assert (ratios[0], ratios[-1]) == (0.05, 20.0)
    assert table.values.holes == 0
    quality = table.values.quality
    assert quality.points >= 500
    assert_quality_is_printed(table, "the table that comes with the program")
    # Against the solver at ellipses and creepages that are no nodes.
    for ratio in (0.13, 1.3):
        solver = EllipseSolver(ratio, 0.28)
        creepages = np.random.default_rng(4).uniform(-1.2, 1.2, (3, 6)) / np.array(solver.scales)[:, None]
        direct, _ = solver.solve(creepages)
        found = table.forces(*creepages, semi_axes=(ratio**0.5, ratio**-0.5), shear_modulus=1.0, friction=1.0, load=1.0)
        np.testing.assert_allclose(found.force_x, direct[0], atol=quality.largest)
        np.testing.assert_allclose(found.force_y, direct[1], atol=quality.largest)
    done = call("table", "query", "--longitudinal", "0,0.002", *CONTACT, "--json")
    nothing, some = (json.loads(line) for line in done.stdout.splitlines())
    assert (nothing["force_x_N"], nothing["force_y_N"], nothing["spin_moment_Nmm"], nothing["gamma_st"]) == (0, 0, 0, 1)
    # What a symmetry makes zero is zero, not noise.
    assert some["force_x_N"] > 0.0 == some["force_y_N"] == some["spin_moment_Nmm"]


def test_bad_queries(tiny: Path, circle: CreepForceTable) -> None:
    contact = ("--shear-modulus-GPa", "82", "--friction", "0.3", "--normal-N", "80000", "--longitudinal", "0.001")
    done = call("table", "query", tiny, "--semi-axes-mm", "5,1", *contact)
    assert (done.returncode, "a/b = 5 is outside the table, which has a/b = 1 alone" in done.stderr) == (3, True)
    done = call("table", "query", tiny, "--semi-axes-mm", "5,1", *contact, "--outside", "saturation", "--json")
    assert json.loads(done.stdout)["force_x_N"] == pytest.approx(24_000, rel=1e-3)
    for axes in ("5", "5,x", "5,0", "-5,1"):
        assert call("table", "query", tiny, f"--semi-axes-mm={axes}", *contact).returncode == 2
    law = FrictionLaw("linear", 0.5, 1.0)
    with pytest.raises(OutsideTable, match=r"a/b = 50 is outside the table, which has a/b = 0\.05 … 20"):
        CreepForceTable.default().forces(1e-3, 0.0, 0.0, semi_axes=(50.0, 1.0), **STEEL)
    for wrong, message in (({"semi_axes": (1.0, 1.1)}, "which has a/b = 1 alone"),
                           ({"friction": 0.0}, "friction must be positive"),
                           ({"law": replace(law, memory=1e-6), "speed": 1.0}, "friction with memory, nor an interlayer"),
                           ({"law": law}, "speed must be positive"), ({"longitudinal": math.inf}, "creepages must be finite"),
                           ({"outside": "nearest"}, "outside is one of error, saturation")):
        creepage = wrong.pop("longitudinal", 1e-3)
        with pytest.raises(OutsideTable if "semi_axes" in wrong else ValueError, match=message):
            circle.forces(creepage, 0.0, 0.0, **{"semi_axes": (1.0, 1.0), **STEEL, **wrong})
    falling = ("--semi-axes-mm", "1,1", "--law", "linear", "--half-slip-m-s", "1", "--speed-m-s", "10", "--limit-coefficient")
    assert call("table", "query", tiny, *contact, *falling, "0.5").returncode == 2
    for without in (falling[4:6], falling[6:8]):
        done = call("table", "query", tiny, *contact, *falling[:2], *without)
        assert (done.returncode, f"{without[0]} belongs to no law" in done.stderr) == (2, True)
    found, plain = (json.loads(call("table", "query", tiny, *contact, *words, "--json").stdout)
                    for words in ((*falling, "0.1"), falling[:2]))
    assert found["force_x_N"] < plain["force_x_N"] and found["force_error_N"] > plain["force_error_N"]
    # One unknown creepage leaves the other answers as they are.
    both = circle.forces([1e-3, math.nan], 0.0, 0.0, semi_axes=(1.0, 1.0), **STEEL)
    assert both.force_x[0] == circle.forces(1e-3, 0.0, 0.0, semi_axes=(1.0, 1.0), **STEEL).force_x and np.isnan(both.force_x[1])
    # And a wheel in the air leaves those of the other wheel as they are.
    lifted = circle.forces(-1e-3, 0.0, 0.0, semi_axes=(1.0, 1.0), **(STEEL | {"load": [STEEL["load"], 0.0]}))
    for name, values in vars(lifted).items():
        assert values[1] == 0.0, name
        assert values[0] == getattr(circle.forces(-1e-3, 0.0, 0.0, semi_axes=(1.0, 1.0), **STEEL), name), name
    for missing in ("--semi-axes-mm", "--shear-modulus-GPa", "--friction", "--normal-N"):
        words = dict(zip(contact[::2], contact[1::2], strict=True)) | {"--semi-axes-mm": "1,1"}
        del words[missing]
        done = call("table", "query", tiny, *(word for pair in words.items() for word in pair))
        assert (done.returncode, missing in done.stderr, "is missing" in done.stderr) == (2, True, True)


def test_bad_files(tiny: Path, tmp_path: Path) -> None:
    whole = tiny.read_bytes()
    path = tmp_path / "t.h5"
    for content, message in ((whole[:-1000], "truncated"), (b"text", "not an HDF5 file")):
        path.write_bytes(content)
        with pytest.raises(ResultFileError, match=message):
            read_table(path)
    path.write_bytes(whole)
    with h5py.File(path, "r+") as file:
        file.attrs["format_version"] = 99
    with pytest.raises(ResultFileError, match="table format 99"):
        read_table(path)
    path.write_bytes(DEFAULT_TABLE.read_bytes())
    with h5py.File(path, "r+") as file:
        file["aspect_ratio"][...] = file["aspect_ratio"][()][::-1]
    with pytest.raises(ResultFileError, match="must increase"):
        read_table(path)
    done = call("table", "query", tmp_path / "none.h5", "--semi-axes-mm", "1,1")
    assert (done.returncode, "no such file" in done.stderr) == (5, True)


def test_a_file_that_is_no_table_is_not_overwritten(tmp_path: Path) -> None:
    (tmp_path / "case.toml").write_text("title = 'mine'\n")
    done = call("table", "build", *TINY, "-o", tmp_path / "case.toml")
    assert done.returncode == 2 and "it is not overwritten" in done.stderr
    assert (tmp_path / "case.toml").read_text() == "title = 'mine'\n"
