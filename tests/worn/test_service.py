"""Wear of a wheelset over the positions of its service: conservation, what changes nothing, resuming, and the command."""

from __future__ import annotations

import csv
import json
import math
import shutil
from pathlib import Path

import h5py
import numpy as np
import pytest

from tests.support.command_line import call
from tests.support.wheelsets import ROOT
from thermoroll_cli import Case, CaseError, read_result, solve, wear
from thermoroll_cli.many_contacts.wheelset.curves import curve
from thermoroll_cli.one_contact.steady_state.scalars import worn_per_passage
from thermoroll_cli.plots.service_figure import service_figure
from thermoroll_cli.studies.worn.follow import Evolution
from thermoroll_cli.studies.worn.outlines import WornOutline, flange
from thermoroll_cli.studies.worn.service import depths_of, outlines_of
from thermoroll_cli.tools.journal import JournalError

RATE = 1e-5
SHIFT, YAW = "wheelset.lateral_shift_mm", "wheelset.yaw_mrad"
ONE = Case.read(ROOT / "cases" / "manchester.toml").with_values({
    "numerics.grid": 8, "thermal.heat": False, "wheelset.wheels": "right", "wheelset.angular_velocity_rad_s": 4.3345,
    "wheelset.vertical_N": 1e4, "wheelset.patches": "planar", "wheelset.lateral_shift_mm": 3.0,
    "wear.upper.specific_wear_rate_mm3_Nm": RATE, "wear.lower.specific_wear_rate_mm3_Nm": 2e-5,
    "wear.lower.track_length_m": 100.0, "wear.depth_um": 4.0})  # fmt: skip
A, B = {SHIFT: 2.0, YAW: 1.0}, {SHIFT: 4.0}
BOTH = ONE.with_values({"wear.positions": [[0.7, A], [0.3, B]], "wear.step_um": 20.0})


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder with m.toml, which has both positions, what the command has written in results, and what it has printed."""
    folder = tmp_path_factory.mktemp("whole")
    (folder / "m.toml").write_text(BOTH.to_toml())
    done = call("wear", "m.toml", "--json", "-q", cwd=folder)
    assert done.returncode == 0, done.stderr
    (folder / "printed").write_text(done.stdout)
    return folder


def resumed(whole: Path, folder: Path, lines: list[str] | None = None) -> Evolution:
    """The evolution of both positions from their journal, or from other lines of it."""
    journal = whole / "results" / "m_wear.jsonl"
    (folder / journal.name).write_text("".join(lines) if lines else journal.read_text())
    return wear(Case.read(whole / "m.toml"), folder, resume=True)


def followed(positions: list | None, steps: float = 20.0) -> Evolution:
    done = wear(ONE.with_values({"wear.step_um": steps} | ({"wear.positions": positions} if positions else {})))
    assert done.converged, done.reason
    return done


def test_one_position_wears_as_its_patches_do() -> None:
    """The rows of both outlines get what one passage wears off each patch, as of a single contact, at its place."""
    result = solve(ONE)
    (patch,) = result.patches
    outlines = outlines_of(ONE.task)
    depths = depths_of(result, outlines)
    for body, name in (("upper", "wheel_right"), ("lower", "rail_right")):
        worn = worn_per_passage(patch.problem, getattr(patch.problem.wear, body), patch.coupled.fields,
                                float(patch.x[1] - patch.x[0]))
        outline = outlines[name]
        area = patch.coupled.scalars[f"wear_area_{body}_um2"]
        assert depths[name].sum() * outline.size * 1e12 == pytest.approx(area, rel=1e-9)
        assert depths[name].max() == pytest.approx(worn.max(), rel=0.02)
        # The mean place of the wear is that of the contact on the profile.
        places = (np.arange(len(outline.depth)) + 0.5) * outline.size
        middle = float(np.interp((depths[name] @ places) / depths[name].sum(), outline._lengths,
                                 curve(outline.points).samples[0]))
        y = "y_wheel_mm" if body == "upper" else "y_rail_mm"
        assert 1e3 * middle == pytest.approx(patch.record[y], abs=1.0)


@pytest.mark.slow
def test_worn_volumes_are_those_of_the_frictional_work() -> None:
    """Σ w κ T_γ/μ per distance, whatever the smoothing: the area on rows is that of the patches."""
    done = followed([[0.7, A], [0.3, B]], steps=2.5)
    means = np.array([row["T_gamma_N"] for row in done.rows])
    distance = np.array([row["distance_km"] for row in done.rows]) * 1e3
    volume = RATE * float(means[:-1] @ np.diff(distance)) / 0.3 * 1e-3  # mm³ to cm³
    assert done.rows[-1]["worn_volume_wheel_right_cm3"] == pytest.approx(volume, rel=1e-3)
    rail = 2e-5 * float(means[:-1] @ np.diff(distance)) / 0.3 / 100e3
    assert done.rows[-1]["worn_area_rail_right_mm2"] == pytest.approx(rail, rel=1e-3)
    assert done.rows[-1]["depth_max_wheel_right_um"] == pytest.approx(4.0, rel=1e-9)
    assert len(done.rows) > 2


@pytest.mark.slow
def test_order_and_parts_of_positions_change_nothing(whole: Path, tmp_path: Path) -> None:
    first = resumed(whole, tmp_path)
    other = followed([[3.0, B], [2.0, A], [5.0, A]])
    assert len(first.rows) == len(other.rows) >= 2
    for mine, theirs in zip(first.rows, other.rows, strict=True):
        assert mine == pytest.approx(theirs, rel=1e-9, nan_ok=True)
    single, named = followed(None), followed([[1.0, {SHIFT: 3.0}]])
    for mine, theirs in zip(single.rows, named.rows, strict=True):
        assert mine == pytest.approx(theirs, rel=1e-9, nan_ok=True)


@pytest.mark.parametrize("mirrored", [False, True])
def test_an_outline_moves_along_its_normals(mirrored: bool) -> None:
    """An arc stays an arc, of a wheel with less radius outside and of a rail likewise, in either order of its points."""
    angle = np.linspace(-0.5, 0.5, 41)
    y, z = 0.3 * np.sin(angle), 0.3 * (1.0 - np.cos(angle))
    points = tuple(zip(y.tolist(), z.tolist(), strict=True))
    for wheel, sign in ((False, 1.0), (True, -1.0)):
        outline = WornOutline.new(tuple(reversed(points)) if mirrored else points, wheel=wheel)
        worn = WornOutline(outline.points, wheel, np.full(len(outline.depth), 1e-3))
        radii = np.hypot(*(np.array(worn.worn) - [0.0, 0.3]).T)
        assert radii == pytest.approx(np.full(len(radii), 0.3 - sign * 1e-3), abs=2e-7)


@pytest.mark.parametrize("angle", [0.0, 1.2, 2.4])
def test_wear_lies_on_the_rows_it_is_worn_off(angle: float) -> None:
    """Between two places along a straight outline, neither of them at a sample or at the end of a row, in either order."""
    direction = np.array([math.cos(angle), math.sin(angle)])
    ends = [[-0.3, 0.2] + 0.02 * k * direction for k in range(2)]
    outline = WornOutline.new(tuple((float(y), float(z)) for y, z in ends), wheel=False)
    line = curve(outline.points).samples[:2]
    first, last, rows = 7.31e-3, 12.87e-3, np.arange(len(outline.depth) + 1) * outline.size
    within = np.diff(np.clip(rows, first, last)) / (last - first)
    for order in (1, -1):
        places = (ends[0] + np.linspace(first, last, 9)[:, None] * direction).T[:, ::order]
        found = outline.deposited(line, places, np.full(8, 0.5e-6))
        assert found * outline.size == pytest.approx(4e-6 * within, abs=1e-12)


def test_flange_of_a_new_wheel_is_that_of_its_drawing() -> None:
    """S1002: Sh 28 mm, Sd 32.5 mm, qR 10.8 mm."""
    wheel = ONE.task.wheels["right"]
    assert np.array(flange(wheel.profile, wheel.flange_back)) * 1e3 == pytest.approx([28.0, 32.5, 10.8], abs=0.05)
    lowered = tuple((y, z - 1e-3 * (y > -0.03)) for y, z in wheel.profile)
    assert flange(lowered, wheel.flange_back)[0] * 1e3 == pytest.approx(29.0, abs=0.05)
    assert math.isnan(flange(wheel.profile, 0.3)[0])


def test_command_writes_resumes_and_shares(whole: Path, tmp_path: Path) -> None:
    printed = json.loads((whole / "printed").read_text())
    assert printed["status"] == "converged" and printed["conicity_3mm"] is None
    folder = whole / "results"
    assert (folder / "m_wear.png").read_bytes().startswith(b"\x89PNG")
    text = (folder / "m_wear.csv").read_text()
    rows = list(csv.DictReader(text.splitlines()))
    assert float(rows[-1]["flange_thickness_right_mm"]) == pytest.approx(32.5, abs=0.1)
    # The last records are lost: the rest is solved again.
    shutil.copy(whole / "m.toml", tmp_path)
    (tmp_path / "results").mkdir()
    lines = (folder / "m_wear.jsonl").read_text().splitlines(keepends=True)
    (tmp_path / "results" / "m_wear.jsonl").write_text("".join(lines[:-3]))
    again = call("wear", "m.toml", "--resume", "-q", "--no-plots", cwd=tmp_path)
    assert again.returncode == 0 and (tmp_path / "results" / "m_wear.csv").read_text() == text, again.stderr
    # The result file has the first position on the worn outlines, which `run --from` solves again and `plot` draws.
    with h5py.File(folder / "m_wear.h5") as file:
        assert file["wear/depth_wheel_right"].shape == (len(file["wear/distance"]), len(file["wear/length_wheel_right"]))
        assert file["wear/depth_wheel_right"][-1].max() == pytest.approx(4e-6, rel=0.02)
        assert file["wear/steps/uncertainty.T_gamma_N"].shape == (len(rows),)
    result = read_result(folder / "m_wear.h5")
    worn = Case.from_json(result.case_json)
    assert worn.task.position.y == pytest.approx(2e-3) and worn.settings.wear.positions == BOTH.settings.wear.positions
    once = json.loads(call("run", "--from", folder / "m_wear.h5", "--json", "-q", "--no-plots", cwd=tmp_path).stdout)
    assert once["T_gamma_N"] == pytest.approx(result["T_gamma_N"], rel=1e-4)
    assert call("plot", folder / "m_wear.h5", "-o", tmp_path / "drawn", "-q", cwd=tmp_path).returncode == 0
    # The worn wheel is a profile as any other.
    used = BOTH.with_values({"wheelset.wheel_profile": {"file": str(folder / "m_worn_wheel_right.csv")}})
    assert used.task.wheels["right"].profile != BOTH.task.wheels["right"].profile


@pytest.mark.parametrize(("values", "words"), [
    ({"wear.positions": [[1.0, {"wheelset.nominal_radius_mm": 450.0}]]}, "position 1 changes the wheelset"),
    ({"wear.positions": [[1.0, {}], [1.0, {"wheelset.lateral_mm": 1.0}]]}, "wear.positions, number 2.*wheelset.lateral_mm"),
    ({"wear.positions": [[1.0, {SHIFT: 1e9}]]}, f"wear.positions, number 1.*{SHIFT}.*1000000000"),
    ({"wear.lower.track_length_m": None}, "a rail has no circumference.*track_length_m"),
])
def test_positions_that_cannot_be_are_errors(values: dict, words: str) -> None:
    with pytest.raises(CaseError, match=f"(?s){words}"):
        wear(ONE.with_values(values))


def from_file(folder: Path, content: str) -> Case:
    (folder / "p.csv").write_text(content)
    text = ONE.to_toml().replace("[wear]\n", '[wear]\npositions_file = "p.csv"\n', 1)
    (folder / "m.toml").write_text(text)
    return Case.read(folder / "m.toml")


def test_positions_from_a_file(tmp_path: Path) -> None:
    """They become those of the case, which no longer needs the file. Equal lines are a weight in parts."""
    for mark in ",;":
        lines = [["weight", SHIFT, YAW], ["0.5", "2", ""], ["0.5", "2", ""], ["1", "-4.5", "1.5"], ["", "", ""]]
        case = from_file(tmp_path, "\n".join(mark.join(line) for line in lines))
        wanted = [[0.5, {SHIFT: 2}], [0.5, {SHIFT: 2}], [1, {SHIFT: -4.5, YAW: 1.5}]]
        assert case == ONE.with_values({"wear.positions": wanted})
        assert Case.parse(case.to_toml()) == Case.from_json(case.to_json()) == case


@pytest.mark.slow
def test_errors_cover_shorter_steps() -> None:
    """The worn area and the depth: the outline becomes more conformal from step to step."""
    asked = {"wear.distance_km": 300.0, "wear.smoothing_mm": 8.0, "numerics.grid": 16}
    coarse, fine = (wear(ONE.with_values(asked | {"wear.step_um": step})).rows for step in (12.0, 4.0))
    assert len(fine) > 1.5 * len(coarse) > 3
    for name in ("depth_max_wheel_right_um", "worn_area_wheel_right_mm2", "worn_mass_wheel_right_kg"):
        apart = abs(coarse[-1][name] - fine[-1][name])
        assert 0.0 < apart < coarse[-1][f"uncertainty.{name}"] < 0.2 * coarse[-1][name]


@pytest.mark.slow
def test_a_failed_step_goes_on_with_another_grid(whole: Path, tmp_path: Path) -> None:
    """Positions that are solved stay as they are, and each step says how fine its grids were."""
    first, *records = (whole / "results" / "m_wear.jsonl").read_text().splitlines(keepends=True)
    failed = {"key": "0/2", "reason": "of a grid", "solved": False}, json.loads(records[2]) | {"solved": False}
    (tmp_path / "m_wear.jsonl").write_text("".join((first, records[0], *(json.dumps(record) + "\n" for record in failed))))
    again = wear(Case.read(whole / "m.toml").with_values({"numerics.grid": 14}), tmp_path, resume=True)
    assert again.converged and again.rows[0]["elements"] > json.loads(records[2])["row"]["elements"]
    kept = [json.loads(line) for line in (tmp_path / "m_wear.jsonl").read_text().splitlines()]
    assert [record.get("key") for record in kept].count("0/1") == 1
    assert again.result is not None and again.result.problem.numerics.grid == (14, 14)
    with pytest.raises(JournalError, match="of another wear"):
        wear(Case.read(whole / "m.toml").with_values({"load.friction_coefficient": 0.2}), tmp_path, resume=True)


def test_validate_checks_the_keys_of_positions(tmp_path: Path) -> None:
    case = ONE.with_values({"wear.positions": [[0.7, A], [0.3, {YAW: 900.0}]]})
    (tmp_path / "m.toml").write_text(case.to_toml())
    done = call("validate", "m.toml", cwd=tmp_path)
    for word in ("m.toml: wear.positions, number 2", f"{YAW} = 900", "allowed", "500"):
        assert done.returncode == 3 and word in done.stderr, done.stderr


def test_a_wheel_beside_its_rail_is_a_reason() -> None:
    done = wear(ONE.with_values({"wear.positions": [[1.0, {SHIFT: 300.0}]]}))
    assert not done.converged and done.reason.startswith("step 0, position 1: ")


def test_wear_is_drawn_in_python(whole: Path, tmp_path: Path) -> None:
    done = resumed(whole, tmp_path)
    assert [axes.get_title() for axes in done.plot().axes[:2]] == ["wheel, depth ten times", "rail, depth ten times"]
    (axes,) = done.plot("pressure_max_MPa").axes
    expected = np.transpose([done.table["distance_km"], done.table["pressure_max_MPa"]])
    np.testing.assert_array_equal(axes.get_lines()[0].get_xydata(), expected)


def test_a_flange_that_does_not_wear_has_numbers_that_can_be_read(whole: Path) -> None:
    """Its axis spans a thousandth of its height at least, not what rounding makes of it."""
    rows, new = csv.DictReader((whole / "results" / "m_wear.csv").read_text().splitlines()), outlines_of(BOTH.task)
    figure = service_figure("", [{name: float(value or "nan") for name, value in row.items()} for row in rows],
                            {name: (outline.points, outline.points) for name, outline in new.items()}, converged=True)
    (height,) = (axes for axes in figure.axes if axes.get_ylabel() == "flange height (mm)")
    low, high = height.get_ylim()
    assert high - low >= 0.9e-3 * high > 0.0
