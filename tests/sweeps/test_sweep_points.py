"""What can be swept, how points are made and divided, and what is refused before anything is solved."""

from __future__ import annotations

import csv
import itertools
import json
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from matplotlib.figure import Figure

from tests.support.command_line import MECHANICAL, THERMAL, call
from thermoroll_cli.files.case import Case, CaseError
from thermoroll_cli.files.table_file import read_table
from thermoroll_cli.one_contact.refinement.plan import leaves_out_deformation
from thermoroll_cli.python_api import solve
from thermoroll_cli.studies.sweeps import table_picture
from thermoroll_cli.studies.sweeps.points import LARGEST_BATCH, Axis, Base, Points, key_of, parse_axes, read_points


@pytest.fixture
def case(tmp_path: Path) -> Path:
    path = tmp_path / "spheres.toml"
    path.write_text(MECHANICAL)
    return path


def points_of(text: str, axes: tuple[Axis, ...]) -> list[Case]:
    return list(Points((Base(text, "case.toml", "case"),), axes).checked())


@pytest.mark.parametrize(("text", "values"), [
    ("k.x=0:1:5", (0, 0.25, 0.5, 0.75, 1)), ("k.x=0.1:0.5:5", (0.1, 0.2, 0.3, 0.4, 0.5)),
    ("k.x=1:1000:4:log", (1, 10, 100, 1000)), ("k.x=-1:-0.01:3:log", (-1, -0.1, -0.01)), ("k.x=3:1:3", (3, 2, 1)),
    ("k.x = 32, 64,128", (32, 64, 128)), ("k.x=5e-3", (5e-3,)), ("k.x=.5,inf", (0.5, float("inf"))),
    ("k.x=rolling,sliding", ("rolling", "sliding")), ("k.x=0.5,matched", (0.5, "matched")), ("k.x=true,false", (True, False)),
])
def test_values(text: str, values: tuple[float, ...]) -> None:
    axis = Axis.parse(text)
    assert (axis.key, axis.values) == ("k.x", values)


def test_whole_ends_give_whole_values_where_they_fall_on_them() -> None:
    assert [type(value) for value in Axis.parse("numerics.grid=16:64:4").values] == [int] * 4
    assert [type(value) for value in Axis.parse("k=0:1:3").values] == [int, float, int]
    assert [type(value) for value in Axis.parse("k=0.0:2.0:3").values] == [float] * 3


@given(
    st.floats(-1e6, 1e6, allow_subnormal=False).map(lambda v: float(f"{v:.9g}")),
    st.floats(-1e6, 1e6, allow_subnormal=False).map(lambda v: float(f"{v:.9g}")),
    st.integers(2, 50),
)
def test_ranges_begin_and_end_as_written_and_have_even_steps(start: float, stop: float, count: int) -> None:
    if abs(stop - start) <= 1e-6 * max(abs(start), abs(stop)):
        return
    values = Axis.parse(f"k={start!r}:{stop!r}:{count}").values
    assert (values[0], values[-1], len(values)) == (start, stop, count)
    steps = [after - before for before, after in itertools.pairwise(values)]
    assert max(steps) - min(steps) <= 1e-10 * max(abs(start), abs(stop))


def test_the_last_axis_varies_fastest_and_names_follow_the_numbers() -> None:
    axes = parse_axes(["load.normal_N=10,20", "rolling.speed_m_s=1:3:3"])
    points, cases = Points((Base(THERMAL, "case.toml", "case"),), axes), points_of(THERMAL, axes)
    values = [points.values(number) for number in range(1, 7)]
    assert values == [(10, 1), (10, 2), (10, 3), (20, 1), (20, 2), (20, 3)]
    assert [points.name(number) for number in range(1, 7)] == [f"case_{number:04d}" for number in range(1, 7)]
    assert [(p.problem.normal_force, p.problem.motion.speed) for p in cases] == values
    assert len({key_of(case) for case in cases}) == points.count == len(cases)


def test_a_key_may_be_missing_in_the_case_and_a_force_replaces_its_creepage() -> None:
    text = MECHANICAL.replace("speed_m_s = 1.0\n", "")
    with pytest.raises(CaseError):
        points_of(text, parse_axes(["load.normal_N=1,2"]))
    points = points_of(text, parse_axes(["rolling.speed_m_s=2,3"]))
    assert [point.problem.motion.speed for point in points] == [2.0, 3.0]
    (point,) = points_of(MECHANICAL, parse_axes(["force.longitudinal_N=5"]))
    assert (point.problem.motion.creepage_x, point.problem.motion.force_x) == (None, 5.0)


def test_pictures_do_not_make_another_case() -> None:
    axes = parse_axes(["load.normal_N=1"])
    first, second, third = (
        key_of(points_of(text, axes)[0])
        for text in (MECHANICAL, MECHANICAL + "[output]\nplots = false\n", MECHANICAL.replace("0.28", "0.29"))
    )
    assert first == second != third


@pytest.mark.parametrize("lengths", [(1,), (5,), (6,), (20,), (3, 7), (7, 1), (2, 3, 11)])
def test_batches_are_small_neighbouring_and_never_cross_a_row(lengths: tuple[int, ...]) -> None:
    names = ("load.normal_N", "rolling.speed_m_s", "creepage.spin_rad_mm")
    axes = parse_axes([f"{name}={','.join(str(v + 1) for v in range(n))}" for name, n in zip(names, lengths, strict=False)])
    points = Points((Base(MECHANICAL, "case.toml", "case"),), axes)
    parts = list(points.batches())
    assert [number for part in parts for number in part] == list(range(1, points.count + 1))
    assert max(map(len, parts)) <= LARGEST_BATCH
    row = next((n for n in reversed(lengths) if n > 1), 1)
    assert len(parts) == points.count // row * -(-row // LARGEST_BATCH)
    for part in parts:
        assert len({(number - 1) // row for number in part}) == 1


def test_a_list_of_points(case: Path, tmp_path: Path) -> None:
    listed = tmp_path / "points.csv"
    text = "\ufeffload.normal_N; thermal.heat ;rolling.speed_m_s;;\n60;false;1;;\n\n65; false;2,5\n60;false;2;;\n;;;;\n;;;;\n"
    listed.write_text(text, encoding="utf-8")
    axes = read_points(listed)
    assert [axis.key for axis in axes] == ["load.normal_N", "thermal.heat", "rolling.speed_m_s"]
    assert [axis.values for axis in axes] == [(60, 65, 60), (False, False, False), (1, 2.5, 2)]
    (tmp_path / "tabs.csv").write_text(text.replace(";", "\t"), encoding="utf-8")
    assert read_points(tmp_path / "tabs.csv") == axes
    (tmp_path / "excel.csv").write_text(text[1:], encoding="utf-16")
    assert read_points(tmp_path / "excel.csv") == axes
    (tmp_path / "book.xlsx").write_bytes(b"PK\x03\x04")
    with pytest.raises(ValueError, match="is a workbook, not text"):
        read_points(tmp_path / "book.xlsx")
    (tmp_path / "one.csv").write_text("load.normal_N\n80,5\n")
    assert read_points(tmp_path / "one.csv") == (Axis("load.normal_N", (80.5,)),)
    (tmp_path / "units.csv").write_text("load.normal_N [kN],creepage.longitudinal [%],rolling.speed_m_s [km/h]\n0.08,0.7,36\n")
    assert [axis.values for axis in read_points(tmp_path / "units.csv")] == [(80.0,), (0.007,), (10.0,)]
    (tmp_path / "units.csv").write_text("load.normal [kN];geometry.upper_radius_x [in];load.normal [N/mm]\n0,08;0,375;2\n")
    assert [(axis.key, axis.values) for axis in read_points(tmp_path / "units.csv")] == [
        ("load.normal_N", (80.0,)), ("geometry.upper_radius_x_mm", (9.525,)), ("load.normal_N_mm", (2.0,))]
    record = (Path(__file__).parents[2] / "cases" / "corrugation.csv").read_text()
    (tmp_path / "record.csv").write_text(record.replace("distance [m]", "#distance_m"))  # as docs/record_over_time.md says
    place, load, creepage = read_points(tmp_path / "record.csv")
    assert (place.key, load.key, load.values[:2]) == ("distance_m", "load.normal_N", (80000.0, 86180.0))
    assert (creepage.key, creepage.values[1]) == ("creepage.longitudinal", 0.00129)
    done = call("sweep", case, "--points", listed, "-o", tmp_path / "out", "--set", "numerics.grid=8")
    assert done.returncode == 0, done.stderr
    rows = list(csv.DictReader((tmp_path / "out" / "sweep.csv").read_text().splitlines()))
    assert [(row["load.normal_N"], row["rolling.speed_m_s"], row["friction_limit_N"]) for row in rows] == [
        ("60", "1", "18.0"), ("65", "2.5", "19.5"), ("60", "2", "18.0")]
    assert (tmp_path / "out" / "sweep.png").exists()


def test_labels_of_points_are_columns_and_an_axis(case: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    drawn: list[list[str]] = []
    monkeypatch.setattr(table_picture, "sweep_figure",
                        lambda table, over, **given: drawn.append([*over, *given["only"]]) or Figure())
    listed = "#path_mm,load.normal_N,#place,creepage.longitudinal\n0,60,in,0.001\n7,65,out,0.002\n"
    (tmp_path / "points.csv").write_text(listed)
    done = call("sweep", case, "--points", tmp_path / "points.csv", "-o", tmp_path, "--set", "numerics.grid=8",
                "--x", "path_mm", "--columns", "shear_max_MPa,force_x_N")
    assert done.returncode == 0, done.stderr
    rows = list(csv.DictReader((tmp_path / "sweep.csv").read_text().splitlines()))
    assert [(row["path_mm"], row["place"], row["friction_limit_N"]) for row in rows] == [
        ("0", "in", "18.0"), ("7", "out", "19.5")]
    assert "shear_" in done.stdout and drawn == [["path_mm", "shear_max_MPa", "force_x_N"]]
    assert call("plot", tmp_path / "sweep.csv", "--x", "load.normal_N").returncode == 0 and drawn[1] == ["load.normal_N"]
    assert call("plot", tmp_path / "sweep.csv").returncode == 0 and drawn[2] == ["path_mm"], "the only label with numbers"
    again = call("plot", tmp_path / "sweep.csv", "--columns", "gamma_st,flash_temperature_max_lower_K")
    assert again.returncode == 0 and "flash_temperature_max_lower_K was not computed" in again.stderr
    assert "without recirculating heat it is temperature_rise_max_lower_K" in " ".join(again.stderr.split())
    assert "did you mean force_x_N" in call("plot", tmp_path / "sweep.csv", "--columns", "force_x").stderr
    assert read_table(tmp_path / "sweep.csv").varied == ("path_mm", "load.normal_N", "place", "creepage.longitudinal")
    for options, words in ((("--x", "rolling.speed_m_s"), "--x: rolling.speed_m_s is not varied"),
                           (("--columns", "force_N"), "no scalar is called force_N; did you mean force_")):
        done = call("sweep", case, "--points", tmp_path / "points.csv", "-o", tmp_path / "no", *options)
        assert done.returncode == 2 and words in done.stderr and not (tmp_path / "no").exists()


def test_points_that_differ_in_labels_alone_are_solved_once(case: Path, tmp_path: Path) -> None:
    """The flanks of a cam: each angle has a row, and both of a load the same result, also of --resume and as JSON."""
    (tmp_path / "cam.csv").write_text("#angle_deg,load.normal_N\n-30,60\n0,80\n30,60\n")
    asked = ("sweep", case, "--points", tmp_path / "cam.csv", "-o", tmp_path / "out", "--set", "numerics.grid=8", "--no-plots")
    done = call(*asked)
    assert done.returncode == 0 and "2 result files" in done.stdout, done.stderr
    rows = list(csv.DictReader((tmp_path / "out" / "sweep.csv").read_text().splitlines()))
    assert [(row["angle_deg"], row["friction_limit_N"]) for row in rows] == [("-30", "18.0"), ("0", "24.0"), ("30", "18.0")]
    assert [row["file"] for row in rows] == ["spheres_0001.h5", "spheres_0002.h5", "spheres_0001.h5"]
    assert {path.name for path in (tmp_path / "out").glob("*.h5")} == {row["file"] for row in rows}
    again = call(*asked, "--resume", "--json")
    assert "3 of 3 points are finished already" in again.stderr
    assert [json.loads(line)["over"]["angle_deg"] for line in again.stdout.splitlines()] == [-30, 0, 30]


def test_words_are_swept_and_a_point_of_a_list_is_named(case: Path, tmp_path: Path) -> None:
    case.write_text(THERMAL)
    done = call("sweep", case, "--over", "thermal.peclet=rolling,stationary", "-o", tmp_path, "--set", "numerics.grid=8")
    assert done.returncode == 0, done.stderr
    rows = list(csv.DictReader((tmp_path / "sweep.csv").read_text().splitlines()))
    assert [row["thermal.peclet"] for row in rows] == ["rolling", "stationary"]
    assert (tmp_path / "sweep.png").exists(), "drawn over the words"
    (tmp_path / "points.csv").write_text("load.normal_N\n-5\n")
    done = call("sweep", case, "--points", tmp_path / "points.csv", "-o", tmp_path)
    assert (done.returncode, "--points load.normal_N=-5" in done.stderr) == (3, True)


@pytest.mark.slow
def test_a_sweep_leaves_out_deformation_at_all_points_or_at_none() -> None:
    """γ_c would jump by many times its error where one point leaves out what the next one computes."""
    points = Points((Base(THERMAL.replace("grid = 16", "grid = 32"), "case.toml", "case"),),
                    (Axis("creepage.longitudinal", tuple(0.002 + 0.001 * i for i in range(5))),))
    alone = {leaves_out_deformation(point.problem) for point in points.checked()}
    assert alone == {True, False}
    together = list(points.with_one_decision().checked())
    assert {point.problem.heating.deformation for point in together} == {"always"}
    results = [solve(point.problem) for point in together]
    for one, other in itertools.pairwise(results):
        step = abs(one.coupled.scalars["gamma_c"] - other.coupled.scalars["gamma_c"])
        assert step <= one.uncertainty["gamma_c"] + other.uncertainty["gamma_c"]


def test_nothing_is_decided_for_sweeps_that_agree_or_say_so_themselves() -> None:
    small = Points((Base(THERMAL, "case.toml", "case"),), (Axis("creepage.longitudinal", (1e-4, 2e-4)),))
    assert small.with_one_decision() is small
    assert {point.problem.heating.deformation for point in small.checked()} == {True}
    swept = Points((Base(THERMAL, "case.toml", "case"),), (Axis("thermal.deformation", (True, False, "always")),
                                                  Axis("creepage.longitudinal", (1e-4, 1e-2))))
    assert swept.with_one_decision() is swept
    assert [point.problem.heating.deformation for point in swept.checked()][::2] == [True, False, "always"]


def test_extremes_enclose_all_points() -> None:
    axes = Axis("a.x", (3, 1, 2)), Axis("a.y", ("p", "q")), Axis("a.z", (1.0,))
    corners = {Points((Base("", "", ""),), axes).values(number) for number in Points((Base("", "", ""),), axes).extremes()}
    assert corners == {(x, y, 1.0) for x in (1, 3) for y in ("p", "q")}
    listed = Points((Base("", "", ""),), (Axis("a.x", (3, 1, 2)), Axis("a.y", (0, 5, 7))), listed=True)
    assert list(listed.extremes()) == [1, 2, 3]


def test_points_of_several_cases_are_those_of_each_of_them() -> None:
    """In one sweep, also of a list: names, values, batches, and the case into which the values are put."""
    bases = [Base(MECHANICAL, "a.toml", "dry"), Base(MECHANICAL.replace("0.3\n", "0.1\n"), "b.toml", "wet")]
    axes = (Axis("load.normal_N", (50, 60, 70)), Axis("#", ("x", "y", "z"), label=True))
    for listed in (True, False):
        both, alone = Points.of(bases, axes, listed=listed), Points.of(bases[:1], axes, listed=listed)
        assert (both.count, both.per_case) == (2 * alone.count, alone.count)
        for number in range(1, alone.count + 1):
            first, second = both.over(number), both.over(alone.count + number)
            assert first == {"case": "dry", **alone.over(number)} and second == {"case": "wet", **alone.over(number)}
            assert [both.name(at) for at in (number, alone.count + number)] == [f"dry_{number:04d}", f"wet_{number:04d}"]
            assert [both.case(at).problem.friction.coefficient for at in (number, alone.count + number)] == [0.3, 0.1]
        shifted = [range(batch.start + alone.count, batch.stop + alone.count) for batch in alone.batches()]
        assert [*both.batches()] == [*alone.batches(), *shifted]
    with pytest.raises(ValueError, match="several cases are called dry"):
        Points.of([bases[0], bases[0]], axes)
    with pytest.raises(ValueError, match="a label cannot be called case"):
        Points.of(bases, (*axes, Axis("case", (1, 2, 3), label=True)), listed=True)
    with pytest.raises(ValueError, match="6 points are too many"):
        Points.of(bases, axes[:1], most=5)
