"""`thermoroll import`: input files of CONTACT."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest

from scripts.peers import Halved
from tests.support.command_line import call
from tests.support.sampling import sampled
from tests.support.wheelsets import FOLDER, case_named, outline_points
from thermoroll_cli.cli.import_command import imported, solved
from thermoroll_cli.files.case_errors import CaseError
from thermoroll_cli.files.case_source import Override
from thermoroll_cli.many_contacts.wheelset.placement import RailSide
from thermoroll_cli.peer.deck import cases_in, read_deck
from thermoroll_cli.peer.reference import Forces, reference_forces
from thermoroll_cli.python_api import solve

FIRST, WHEEL, SHIFT = ((FOLDER.parent / "decks" / f"{name}.inp").read_text() for name in ("ellipse", "wheel", "shift"))
"""Input files with values to be filled in: Hertz's ellipse in steady rolling, wheels on rails, shifts."""
SECOND = """
 3  MODULE
  203110     P-B-T-N-F-S
  100000     L-D-C-M-Z-E
 0100241   H-G-I-A-O-W-R
  100000.   0.5     0.001   0.0002             FN, FX, CETA, CPHI
"""
GRID = [Override.parse("numerics.grid=32")]
END = "\n 0  MODULE\n"


def deck_of(folder: Path, text: str, name: str = "deck.inp") -> Path:
    path = folder / name
    path.write_text(text)
    return path


def test_digits_keep_what_was_read_and_forces_keep_their_axes(tmp_path: Path) -> None:
    """CONTACT's example of heat, case 4: 21820 and −4476 N on its elements; rolling the other way turns everything by 180°."""
    found = imported(deck_of(tmp_path, FIRST.format(chi="180d") + SECOND + END))
    force = [solved(each, {}, GRID, tmp_path)["force"] for each in found]
    assert force[0] == pytest.approx([21_820.0, -4_476.0, 100_000.0], rel=0.01)
    assert force[1][0] == pytest.approx(0.5 * 0.3 * 100_000.0)
    turned = FIRST.format(chi="0.0").replace("-0.002    0.001 ", "0.002   -0.001 ")
    back = solved(imported(deck_of(tmp_path, turned + END))[0], {}, GRID, tmp_path)["force"]
    assert back == pytest.approx([-force[0][0], -force[0][1], force[0][2]], rel=1e-9)


@pytest.mark.parametrize(("kind", "area"), [(-1, "0.001015 0.0004215"), (-2, "0.001015 {ratio}"), (-3, "{a} {b}")])
def test_ellipses_are_those_of_the_radii(tmp_path: Path, kind: int, area: str) -> None:
    """Curvatures, one of them with the ratio of the axes, and the axes describe the same contact."""
    plain = imported(deck_of(tmp_path, FIRST.format(chi="0.0") + END))[0].case
    assert plain is not None
    scalars = solve(plain.with_values({"numerics.grid": 16}))
    a, b = scalars["hertz_a_mm"], scalars["hertz_b_mm"]
    head = FIRST.format(chi="0.0").partition("    1                                          IPOTCN\n")[0]
    text = head + f"  {kind}   IPOTCN\n  20 20  {area.format(ratio=a / b, a=a, b=b)} 1.2\n" + END
    case = imported(deck_of(tmp_path, text))[0].case
    assert case is not None and case.settings.geometry is not None and plain.settings.geometry is not None
    for key in ("upper_radius_x_mm", "upper_radius_y_mm"):
        assert getattr(case.settings.geometry, key) == pytest.approx(getattr(plain.settings.geometry, key), rel=1e-6)


@pytest.mark.parametrize("area", [
    " 1\n  60 1  -8.0 -10.0  0.25 20.0\n 1 1\n 0.001015 0.0 0.0\n 0.0 0.0 0.0\n",
    " -4\n  60 1  0.001015 10.0 1.2\n", " -5\n  60 1  {a} 10.0 1.2\n"
])  # fmt: skip
def test_long_bodies_are_line_contacts_of_their_length(tmp_path: Path, area: str) -> None:
    """Of 20 mm, with the force that Carter found."""
    modulus, load, friction, slip = 2.0 * 82_000.0 * 1.28 / (2.0 * (1.0 - 0.28**2)), 5_000.0, 0.3, 0.0002
    half = (4.0 * load * 0.5 / 0.001015 / (np.pi * modulus)) ** 0.5
    head = FIRST.format(chi="180d").partition("    1                                          IPOTCN\n")[0]
    head = head.replace("-0.002    0.001    2d-4", f"-{slip}   0.0    0.0")
    found = imported(deck_of(tmp_path, head + area.format(a=half) + END))[0]
    assert found.case is not None and found.case.settings.load is not None, found.reason
    assert found.case.settings.load.normal_N_mm == pytest.approx(load)
    carter = 1.0 - (1.0 - slip * 0.5 / 0.001015 / (friction * half)) ** 2
    force = solved(found, {}, [], tmp_path)["force"]
    assert force == pytest.approx([friction * 100_000.0 * carter, 0.0, 100_000.0], rel=2e-3, abs=1e-6)
    head = head.replace(f"-{slip}", "0.5").replace("203100", "203110")
    given = imported(deck_of(tmp_path, head + area.format(a=half) + END))[0]
    assert given.case is not None and given.case.settings.force is not None, given.reason
    assert given.case.settings.force.longitudinal_N_mm == pytest.approx(-0.5 * friction * load)
    step = imported(deck_of(tmp_path, head.replace("203110", "202110") + area.format(a=half) + END))[0]
    assert step.case is not None and step.case.settings.history is not None, step.reason
    assert step.case.settings.history.length_mm == pytest.approx(20.0) and step.case.settings.history.begin == "pressed"


BEFORE = SHIFT.format(digits="201110", load="0.4705", slip="-0.657", spin="0.0", rolling="", b4=0.0, b5=0.0, b6=0.0)


def shifted(x: float, y: float = 0.0, **more: object) -> str:
    """A case of which the closest place is at (x, y)."""
    b4, b5, b6 = -2.0 * 0.002963 * x, -2.0 * 0.002963 * y, 0.002963 * (x**2 + y**2)
    return SHIFT.format(
        **({"digits": "001100", "load": 0.4705, "spin": 0.0, "rolling": "", "b4": b4, "b5": b5, "b6": b6} | more)
    )


def test_a_contact_that_moves_over_material_at_rest_rolls(tmp_path: Path) -> None:
    rolling = shifted(0.0, digits="002100", slip=-0.002, rolling="   0.0   0.25   1000.\n")
    forces = []
    for text in (rolling, shifted(0.25, slip=-0.0005)):
        found = imported(deck_of(tmp_path, BEFORE + text + END))
        forces.append([solved(each, {}, GRID, tmp_path)["force"] for each in found][1])
    assert forces[1] == pytest.approx(forces[0], rel=1e-6, abs=1e-9) and forces[0][0] < -0.06
    back = imported(deck_of(tmp_path, BEFORE + shifted(-0.25, slip=-0.0005) + END))[1]
    assert back.case is None and back.reason.startswith("IBASE = 1: a contact that moves")
    # A force relative to the load at a given approach, which is Hertz's.
    pressed = imported(deck_of(tmp_path, BEFORE + shifted(0.25, digits="001010", load=0.07258, slip=-0.657) + END))[1]
    assert pressed.case is not None and pressed.case.settings.force is not None
    assert pressed.case.settings.force.longitudinal_N == pytest.approx(-0.657 * 0.4 * 0.4705, rel=1e-3)


def test_spin_turns_about_the_origin_of_a_shifted_contact(tmp_path: Path) -> None:
    rolling = "   0.0   0.25   1000.\n"
    text = shifted(1.0, 2.0, digits="203100", slip=-0.002, spin=0.001, rolling=rolling)
    case = imported(deck_of(tmp_path, text + END))[0].case
    assert case is not None and case.settings.creepage is not None
    creepage = case.settings.creepage
    assert [creepage.longitudinal, creepage.lateral, creepage.spin_rad_mm] == pytest.approx([0.004, -0.001, 0.001])


def test_a_third_body_hardens(tmp_path: Path) -> None:
    text = FIRST.format(chi="0.0").replace("022020", "022420")
    text = text.replace("    1                  ", " 820. 0.02 60. -1000.\n    1  ", 1)
    case = imported(deck_of(tmp_path, text + END))[0].case
    assert case is not None
    layer = case.problem.interlayer
    assert [layer.compliance, layer.yield_stress, layer.hardening] == pytest.approx([0.02e-3 / 820e6, 60e6, -1e12])


def test_the_suite_is_run_on_halved_elements(tmp_path: Path) -> None:
    """`scripts.peers --halved`: elements and, in steady rolling, the distance of a step; all else stays."""
    text = FIRST.format(chi="0.0") + SECOND + END
    lines = Halved("deck.inp", text.splitlines())
    before, after = read_deck(deck_of(tmp_path, text)), list(cases_in(lines))
    halved = read_deck(deck_of(tmp_path, "\n".join(lines.lines)))
    assert [each.values for each in after] == [each.values for each in before]
    for one, other in zip(before, halved, strict=True):
        assert {**one.values["area"], "MX": 120, "MY": 120, "DX": 0.1, "DY": 0.25} == other.values["area"]
        assert {**one.values["rolling"], "DQ": 0.1} == other.values["rolling"]
        assert one.values["motion"] == other.values["motion"]


def test_bodies_that_relax_at_once_are_the_relaxed_ones(tmp_path: Path) -> None:
    text = FIRST.format(chi="0.0").replace("022020", "022120")
    text = text.replace("    1                  ", " 3.0 3.0 0.0 0.0\n    1  ", 1)
    case = imported(deck_of(tmp_path, text + END))[0].case
    assert case is not None and not case.problem.relaxes
    assert case.problem.lower.youngs_modulus == pytest.approx(2e6 * 82_000.0 * 1.28 / 4.0)


def test_stresses_over_time_are_left_out_by_name(tmp_path: Path) -> None:
    deck = deck_of(tmp_path, FIRST.format(chi="0.0").replace("203100", "202101") + END)
    done = call("import", deck, "-o", tmp_path, "--json")
    assert json.loads(done.stdout)["without"] == [{"case": 1, "without": "S = 1: stresses below the surface over time"}]
    assert "subsurface" not in (tmp_path / "deck_1.toml").read_text()


@pytest.mark.parametrize(("change", "reason"), [
    (("022020", "022320"), "M = 3"), (("203100", "200100"), None), (("203100", "233100"), "B = 3"),
    (("022020", "022029"), "E = 9"), (("203100", "202100"), None),
    (("0.001015  0.0  0.0004215", "0.001015  0.1  0.0004215"), "IBASE = 1"), (("   60   60 ", "    1    1 "), "MX = MY = 1"),
])  # fmt: skip
def test_what_is_left_out_is_named(tmp_path: Path, change: tuple[str, str], reason: str | None) -> None:
    text = FIRST.format(chi="0.0").replace(*change, 1)
    if "320" in change[1]:
        text = text.replace("    1                                          IPOTCN", " 1.0 1.0 1.0\n 1 IPOTCN")
    if change[1].startswith("200100"):
        text = text.replace("   0.0    0.200    30000.                    CHI, DQ, VELOC\n", "")
    if change[1].endswith("9"):
        text += "0.0 " * 7200 + "\n"
    found = imported(deck_of(tmp_path, text + END))[0]
    assert (found.case is None) == (reason is not None), found.reason
    assert found.reason.startswith(reason or "")


@pytest.mark.parametrize(("text", "line", "message"), [
    (FIRST.format(chi="0.0"), 18, "ends where"), (FIRST.format(chi="0.0")[:600], None, "ends where"),
    (FIRST.format(chi="0.0").replace("82000. ", "stiff "), 11, "GG1"), (" 7 MODULE\n", 1, "module 7"),
    (" 3 MODULE\n 99999999\n", 2, "no control digits"), ("", 1, "ends where")])  # fmt: skip
def test_broken_files_are_refused_with_their_line(tmp_path: Path, text: str, line: int | None, message: str) -> None:
    path = deck_of(tmp_path, text)
    with pytest.raises(CaseError, match=message) as caught:
        read_deck(path)
    assert caught.value.findings[0].source == str(path)
    span = caught.value.findings[0].span
    assert span is not None and line in (None, span.line)


def wheel_deck(name: str, **more: object) -> str:
    given = case_named(name)
    i = given["input"]
    values = {
        "side": int(i["side"] == "right"), "folder": str(FOLDER.parents[2] / "cases"), "rail": "MBench_UIC60_v3.prr",
        "y": i["y"], "z": given["contact"]["z_ws_mm"], "roll": i["roll"], "yaw": i["yaw"], "omega": i["omega"]}
    return WHEEL.format(**(values | more)) + END


@pytest.mark.parametrize("side", sampled(["left", "right"]))
def test_wheels_have_the_forces_of_contact(tmp_path: Path, side: str) -> None:
    name = f"A2.2 {side} y=4.0"
    each = imported(deck_of(tmp_path, wheel_deck(name)))[0]
    row = solved(each, {1: Forces(case_named(name)["contact"]["force_rail_track_N"], [])}, GRID, tmp_path)
    assert row["force"] == pytest.approx(row["reference"], abs=0.002 * 10_000.0)


ROLLER = "   14.0   0   1435.0   800.0\n"


def test_a_wheel_that_travels_backwards_is_one_of_the_other_side(tmp_path: Path) -> None:
    deck = wheel_deck("A2.2 right y=5.0")
    forward = imported(deck_of(tmp_path, deck))[0]
    given = case_named("A2.2 right y=5.0")["input"]
    back = wheel_deck("A2.2 right y=5.0", side=0, y=-given["y"], roll=-given["roll"], omega=-given["omega"])
    backward = imported(deck_of(tmp_path, back.replace(" 2000. ", " -2000. ")))[0]
    assert forward.case is not None and backward.case is not None and forward.axes is not None and backward.axes is not None
    assert backward.case.settings == forward.case.settings
    scalars = {f"track_force_{axis}_right_N": value for axis, value in zip("xyz", (1.0, 2.0, 3.0), strict=True)}
    assert forward.axes.force(scalars) == [1.0, 2.0, 3.0] and backward.axes.force(scalars) == [-1.0, -2.0, 3.0]


def test_wheels_on_rollers(tmp_path: Path) -> None:
    """The radius is that of z = 0 of the outline, whose top lies elsewhere."""
    deck = wheel_deck("A2.2 left y=4.0", side=4).replace("   14.0   0   1435.0   0.0\n", ROLLER)
    case = imported(deck_of(tmp_path, deck.replace(" 2000. ", " 2.5 ")))[0].case
    assert case is not None and case.settings.track is not None and case.settings.track.left is not None
    assert (case.settings.track.roller_radius_mm, case.settings.track.roller_angular_velocity_rad_s) == (800.0, 2.5)
    assert case.settings.rolling is not None and case.settings.rolling.speed_m_s == pytest.approx(2.0)
    assert case.settings.track.left.shift_z_mm == pytest.approx(min(1e3 * z for _, z in outline_points("MBench_UIC60_v3.prr")))
    roller = " 1  MODULE\n 4203000\n 0100002\n 0100321\n 0 0 0 0 0 0\n 2.5 0 0 0 0 -4.3\n"
    kept = imported(deck_of(tmp_path, wheel_deck("A2.2 left y=4.0").replace(END, roller + END)))[1]
    assert kept.case is None and kept.reason == "C1: no earlier case has the track that is kept"


def test_wheels_may_be_off_their_place_on_the_axle(tmp_path: Path) -> None:
    """The wheel turns with its axle: what lies lower moves faster by that. A roll of it lifts the axle of the surface alone."""
    flexible = "  0.0 {y} {z}  {roll} 0.0 0.0\n  0.0 0.0 0.0  0.0 0.0 0.0\n"
    plain = imported(deck_of(tmp_path, wheel_deck("A2.2 right y=5.0")))[0].case
    cases = []
    for off in ({"y": 0.5, "z": 0.25, "roll": 0.0}, {"y": 0.0, "z": 0.0, "roll": 0.01}):
        deck = wheel_deck("A2.2 right y=5.0").replace("0022033", "0022035").replace(END, flexible.format(**off) + END)
        cases.append(imported(deck_of(tmp_path, deck))[0].case)
    assert plain is not None and all(case is not None for case in cases)
    before, moved, rolled = (case.settings for case in (plain, *cases) if case is not None)
    assert before.wheelset is not None and moved.wheelset is not None and rolled.wheelset is not None
    assert before.rolling is not None and moved.rolling is not None
    omega = before.wheelset.angular_velocity_rad_s
    assert omega is not None and before.rolling.speed_m_s is not None
    assert moved.wheelset.lateral_shift_mm == pytest.approx(before.wheelset.lateral_shift_mm + 0.5, abs=1e-3)
    assert moved.wheelset.height_mm == pytest.approx(before.wheelset.height_mm + 0.25, abs=1e-3)
    assert moved.rolling.speed_m_s == pytest.approx(before.rolling.speed_m_s - 0.25e-3 * omega, rel=1e-6)
    assert rolled.wheelset.roll_mrad == pytest.approx(before.wheelset.roll_mrad + 10.0, rel=1e-3)
    assert rolled.wheelset.yaw_rate_mrad_s == pytest.approx(10.0 * omega, rel=1e-3)
    # The wheel rolls about the nominal point of its tread, which stays: (0, 750, 460) mm from the axle's middle.
    (y, z), (y_rolled, z_rolled) = (
        (750.0 * math.cos(roll) - 460.0 * math.sin(roll), 750.0 * math.sin(roll) + 460.0 * math.cos(roll))
        for roll in (1e-3 * before.wheelset.roll_mrad, 1e-3 * rolled.wheelset.roll_mrad)
    )
    assert rolled.wheelset.lateral_shift_mm == pytest.approx(before.wheelset.lateral_shift_mm + y - y_rolled, abs=2e-3)
    assert rolled.wheelset.height_mm == pytest.approx(before.wheelset.height_mm + z - z_rolled, abs=2e-3)


def test_absolute_places_of_rails_are_those_of_the_gauge(tmp_path: Path) -> None:
    profile = outline_points("MBench_UIC60_v3.prr")
    by_gauge = RailSide(profile, 0.025, 0.7175, 0.014, 1e-3, 2e-3, 0.01)
    bare = RailSide(profile, 0.025, 0.7175, 0.014)
    y, z = (bare.samples - RailSide(profile, 0.025, 0.0, 0.0, origin=(0.0, 0.0)).samples)[:2, 0]
    placed = RailSide(profile, 0.025, 0.0, 0.014, 1e-3, 2e-3, 0.01, origin=(float(y), float(z)))
    assert np.abs(placed.samples - by_gauge.samples).max() < 1e-12
    text = (
        wheel_deck("A2.2 left y=4.0")
        .replace("   14.0   0   1435.0", f"   -1.0  {-1e3 * y}  {1e3 * z}")
        .replace(" 0.0\n  '", " 0.025\n  '", 1)
    )
    case = imported(deck_of(tmp_path, text))[0].case
    assert case is not None and case.settings.track is not None and case.settings.track.left is not None
    assert case.settings.track.left.origin_mm == pytest.approx([1e3 * y, 1e3 * z])


def test_the_command_writes_compares_and_reports(tmp_path: Path) -> None:
    text = FIRST.format(chi="180d") + SECOND.replace("203110", "243110") + END
    deck = deck_of(tmp_path, text)
    (tmp_path / "deck.ref_out").write_text(
        " Case     1\n TOTAL FORCES, TORSIONAL MOMENT, ELASTIC ENERGY, FRICTIONAL POWER\n     FN   FX   FY   MZ\n"
        "       1.000E+05   2.182E+04   -4476.   1.0\n"
    )
    assert reference_forces(tmp_path / "deck.ref_out")[1].whole == [21_820.0, -4_476.0, 100_000.0]
    of_patch = "\n TOTAL FORCES, TORSIONAL MOMENT\n     FN   FX   FS   MN\n      {}\n"
    (tmp_path / "two.ref_out").write_text(
        " Case     1\n TOTAL FORCES ON RAIL\n    FX(TR)   FY(TR)   FZ(TR)\n    1.  2.  30.\n"
        + of_patch.format("20.  3.  -4.  0.1") + of_patch.format("12.  -1.  5.  0.1"))
    assert reference_forces(tmp_path / "two.ref_out") == {1: ([1.0, 2.0, 30.0], [2.0, 1.0, 32.0])}
    done = call("import", deck, "-o", tmp_path / "cases", "--run", "--json", "--set", "numerics.grid=24")
    assert done.returncode == 0, done.stderr
    record = json.loads(done.stdout)
    assert (record["cases"], record["written"]) == (2, ["deck_1"])
    assert record["left_out"] == [{"case": 2, "reason": "B = 4: an approximate pressure"}]
    assert record["compared"][0]["force"] == pytest.approx(record["compared"][0]["reference"], rel=0.02)
    assert call("validate", tmp_path / "cases" / "deck_1.toml").returncode == 0
    assert sorted(path.name for path in (tmp_path / "cases").iterdir()) == ["deck_1.h5", "deck_1.toml"]
    assert record["files"] == [str(tmp_path / "cases" / name) for name in ("deck_1.toml", "deck_1.h5")]


def test_a_case_that_has_no_solution_says_why(tmp_path: Path) -> None:
    deck = deck_of(tmp_path, FIRST.format(chi="180d") + END)
    without = "--set", "creepage.longitudinal=0.001", "--set", "force.lateral_N=1e9"
    done = call("import", deck, "-o", tmp_path / "cases", "--run", *without)
    assert done.returncode == 4 and "case 1: invalid, force none N: force.lateral_N = 1e9: the tangential" in done.stdout
    assert "1 of 1 cases" in done.stdout and f"wrote {tmp_path / 'cases' / 'deck_1.toml'}" in done.stdout


def test_errors_leave_nothing_behind(tmp_path: Path) -> None:
    deck = deck_of(tmp_path, wheel_deck("A2.2 left y=4.0", rail="none.prr"))
    done = call("import", deck, "-o", tmp_path / "cases")
    assert done.returncode == 3 and "deck.inp:10:1" in done.stderr and "none.prr" in done.stderr
    assert not (tmp_path / "cases").exists()
    assert call("import", deck_of(tmp_path, END), "-o", tmp_path / "cases").returncode == 3
    missing = call("import", tmp_path / "missing.inp")
    assert missing.returncode == 3 and "missing.inp: error: no such file" in missing.stderr
    ignored = call("import", deck, "--set", "numerics.grid=x")
    assert ignored.returncode == 2 and "cases that --run solves" in ignored.stderr
    assert call("import", deck_of(tmp_path, FIRST.format(chi="0.0") + END), "--case", "2").returncode == 2
