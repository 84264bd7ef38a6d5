"""Profiles in case files: every form, every mistake with its place, and that a result reproduces without the file of points."""

from __future__ import annotations

import json
import re

import numpy as np
import pytest

from tests.support.command_line import MECHANICAL, call
from tests.support.documents import ROOT
from thermoroll_cli.files.case import Case, CaseError
from thermoroll_cli.files.result.outcome import read_result
from thermoroll_cli.plots.profile_figures import profile_figure
from thermoroll_cli.plots.run_frame import frame_of
from thermoroll_cli.problem.geometry import Profile, rough_warning

WITHOUT = MECHANICAL.replace("upper_radius_y_mm = 30.0\n", "")
POINTS = "points_mm = [[-2.0, -0.0667], [-1.0, -0.01667], [0.0, 0.0], [1.0, -0.01667], [2.0, -0.0667]]\n"
FILE = "# measured\ny_mm, height_mm\n-2.0, -0.0667\n-1.0, -0.01667\n0.0, 0.0\n1.0, -0.01667\n2.0, -0.0667\n"


def case(profile: str, base: str = WITHOUT) -> str:
    return base.replace("[load]", f"[geometry.upper_profile]\n{profile}[load]")


def fault(text: str) -> str:
    with pytest.raises(CaseError) as caught:
        Case.parse(text, name="case.toml")
    return str(caught.value)


def test_every_form_of_a_profile(tmp_path):
    (tmp_path / "roller.csv").write_text(FILE)
    (tmp_path / "case.toml").write_text(case('file = "roller.csv"\noffset_mm = 0.1\ntilt_mrad = 2.0\n'))
    read = Case.read(tmp_path / "case.toml").problem.geometry
    given = Case.parse(case(POINTS + "offset_mm = 0.1\ntilt_mrad = 2.0\n")).problem.geometry
    assert read == given and (not read.elliptic)
    assert read.upper_profile is not None and read.upper_profile.points[1] == (-1e-3, -1.667e-5)
    crown = Case.parse(case('kind = "logarithmic"\nlength_mm = 10.0\ndrop_um = 1.0\nflat_mm = 2.0\n')).problem.geometry
    assert crown.upper_profile == Profile(length=0.01, drop=1e-6, flat=2e-3)
    straight = Case.parse(case(POINTS + 'interpolation = "linear"\n')).problem.geometry.upper_profile
    assert straight is not None and straight.interpolation == "linear"


FIVE = [[-2.0, -0.0667], [-1.0, -0.01667], [0.0, 0.0], [1.0, -0.01667], [2.0, -0.0667]]
ROWS = FILE.splitlines()[2:]
PRR, BAN = ((ROOT / "tests" / "reference" / "synthetic_profiles" / f"roller.{ending}").read_text() for ending in ("prr", "ban"))


def profile_in(tmp_path, name: str, content: str | bytes) -> list[list[float]]:
    (tmp_path / name).write_bytes(content if isinstance(content, bytes) else content.encode())
    (tmp_path / "case.toml").write_text(case(f'file = "{name}"\n'))
    points = Case.read(tmp_path / "case.toml").settings.geometry.upper_profile.points_mm
    return [pytest.approx(point) for point in points]


@pytest.mark.parametrize("separator", [";", "\t", "  ", ",", " ; ", " , "])
def test_columns_may_be_separated_in_many_ways(tmp_path, separator):
    content = "\n".join(line.replace(", ", separator) for line in FILE.splitlines())
    assert profile_in(tmp_path, "roller.txt", content) == FIVE


@pytest.mark.parametrize("separator", [";", "\t", "  ", ", "])
def test_numbers_may_have_a_decimal_comma(tmp_path, separator):
    rows = (separator.join(entry.replace(".", ",") for entry in row.split(", ")) for row in ROWS)
    assert profile_in(tmp_path, "roller.txt", "\r\n".join(rows)) == FIVE


@pytest.mark.parametrize("head", ["", "Profil 7;\n\ny [mm];Höhe [mm]\n", '"y, mm","height, mm"\n'])
@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "cp1252"])
def test_files_as_a_spreadsheet_saves_them(tmp_path, head, encoding):
    """Marks in front, header lines, quotes around numbers, and points from right to left."""
    rows = (";".join(f'"{entry}"'.replace(".", ",") for entry in row.split(", ")) for row in reversed(ROWS))
    assert profile_in(tmp_path, "roller.csv", (head + "\n".join(rows)).encode(encoding)) == FIVE


@pytest.mark.parametrize("blank", [";", ",", "\t"])
def test_blank_rows_and_columns_that_a_spreadsheet_adds_are_ignored(tmp_path, blank):
    rows = [row.replace(", ", blank) + 2 * blank for row in ROWS]
    assert profile_in(tmp_path, "roller.csv", "\n".join([*rows, 3 * blank, 3 * blank, ""])) == FIVE


def test_profiles_of_railways(tmp_path):
    """Simpack's z points down, into a rail and out of a wheel; MiniProf's out of a wheel, and of rails up or down, as
    the gauge face shows."""
    wheel = [[y, -height] for y, height in FIVE]
    assert profile_in(tmp_path, "rail.prr", PRR) == FIVE
    assert profile_in(tmp_path, "wheel.PRW", PRR) == wheel
    metres = re.sub(r"^( +-?\d.*?)  +(-?[\d.]+)", lambda row: f"{float(row[1]) / 1e3} {float(row[2]) / 1e3}", PRR, flags=re.M)
    metres = metres.replace("units.len.f = 1000.0", "units.len.f = 1.0").replace("shift.y = 0.5", "shift.y = 0.0005")
    assert profile_in(tmp_path, "metres.prr", metres) == FIVE
    assert profile_in(tmp_path, "mirrored.prr", PRR.replace("mirror.y = 0", "mirror.y = 1\n  mirror.z = 1")) == wheel
    bounded = PRR.replace("shift.y", "bound.y.min = -1.2\nbound.y.max = 1.2\nshift.y")
    assert profile_in(tmp_path, "bounded.prr", bounded) == FIVE[1:-1]
    assert profile_in(tmp_path, "rail.ban", BAN) == FIVE
    assert profile_in(tmp_path, "wheel.whl", BAN) == FIVE
    down = BAN.replace(" -0.0", " 0.0")
    assert profile_in(tmp_path, "down.ban", down) == FIVE
    assert profile_in(tmp_path, "out.whl", down) == wheel


def test_show_says_how_a_profile_was_read(tmp_path):
    """As the case has it: with its own mirror, the units of the file, points that fold back, the flange of a wheel."""
    for name, mirror, told, record in (
        ("wheel.prw", False, "Simpack, 5 of 7 points in mm, y from -2 to 2 mm, height from 0 to 0.0667 mm, signs as in the "
         "file, flange at -y", {"flange": "-y", "mirrored": False, "turned": False, "points_in_file": 7}),
        ("rail.prr", True, "height from -0.0667 to 0 mm, sign of y and height changed",
         {"flange": None, "mirrored": True, "turned": True, "y_mm": [-2.0, 2.0]}),
        ("rail.ban", False, "MiniProf, 5 points in mm", {"turned": False, "height_mm": [-0.0667, 0.0]}),
        ("roller.csv", True, "two columns, 5 points in mm", {"mirrored": True, "turned": False, "file": "roller.csv"}),
    ):
        content = BAN if name.endswith("ban") else FILE if name.endswith("csv") else PRR
        (tmp_path / name).write_text(content)
        (tmp_path / "case.toml").write_text(case(f'file = "{name}"\nmirror = {str(mirror).lower()}\n'))
        shown = " ".join(call("show", tmp_path / "case.toml").stdout.split())
        assert f"geometry.upper_profile {name}: " in shown and told in shown, shown
        (read,) = json.loads(call("show", tmp_path / "case.toml", "--json").stdout)["profiles"].values()
        assert read.items() >= record.items()


@pytest.mark.parametrize(("factors", "advice"), [
    ((1.0, -1.0), "point into the body: turn the sign of the heights"),
    ((1e-3, 1e-3), "be in metres: give them in mm"),
    ((1.0, 1.0), ""),
])  # fmt: skip
def test_a_warning_says_which_mistake_makes_a_profile_impossible(tmp_path, factors, advice):
    points = [[factors[0] * y, factors[1] * height] for y, height in FIVE]
    (tmp_path / "case.toml").write_text(case(f"points_mm = {points}\n"))
    told = call("validate", tmp_path / "case.toml").stderr
    assert ("geometry.upper_profile may" in told) == bool(advice) and advice in told, told
    # Under a load that is too large in mm, too, metres still make the difference.
    heavy = call("validate", tmp_path / "case.toml", "--set", "load.normal_N=1e8").stderr
    assert ("in metres" in heavy) == ("in metres" in advice), heavy


@pytest.mark.parametrize(("name", "content", "told", "hint"), [
    ("a.prr", PRR.replace("mirror.y = 0", "rotate = 2.5"), "a rotated profile (rotate = 2.5) is", "tilt_mrad"),
    ("a.prw", PRR.replace("-0.5  0.0", "-0.5  zero"), "line 14: no point with two numbers: -0.5  zero", ""),
    ("a.ban", BAN.replace("X,Y,A", "A,C"), "ColumnDef=A,C names no X and Y", ""),
    ("a.whl", "ProgramName=MiniProf\n", "two points at least", "two columns"),
    ("a.csv", "-1,0,0,5\n1,0,0,5\n", "line 1: 4 columns instead of two", "separate the columns by semicolons"),
    ("a.csv", "-1;1.000,5\n1;0\n", "line 1: not a number: 1.000,5", "nothing between thousands"),
    ("a.xlsx", "PK\x03\x04", "a.xlsx is a workbook, not text", "save its sheet as CSV"),
])  # fmt: skip
def test_files_that_cannot_be_read_say_what_helps(tmp_path, name, content, told, hint):
    with pytest.raises(CaseError) as caught:
        profile_in(tmp_path, name, content)
    (finding,) = caught.value.findings
    assert told in finding.message and hint in finding.hint and finding.key == "geometry.upper_profile.file"
    assert finding.span is not None and finding.span.line == 10


def test_a_body_has_a_radius_or_a_profile():
    assert "cannot be given together with geometry.upper_radius_y_mm" in fault(case(POINTS, MECHANICAL))
    assert "or a table [geometry.upper_profile]" in fault(WITHOUT)
    never = case(POINTS + "offset_mm = -4.0\n").replace("lower_radius_y_mm = 30.0\n", "").replace(
        "[load]", "[geometry.lower_profile]\n" + POINTS + "offset_mm = 4.0\n[load]") + "[output]\nplots = false\n"
    never = never.replace("speed_m_s = 1.0", "speed_m_s = 1.0\ndifferential_slip = false")
    assert "never face each other" in fault(never)


def test_one_form_replaces_another(tmp_path):
    """With --set, and from point to point of a sweep: radius for profile, crown for points."""
    given = Case.parse(case(POINTS))
    assert given.with_values({"geometry.upper_radius_y_mm": 30.0}).settings.geometry.upper_profile is None
    crown = {"kind": "logarithmic", "length_mm": 10.0, "drop_um": 1.0}
    other = given.with_values({f"geometry.upper_profile.{key}": value for key, value in crown.items()})
    assert other.problem.geometry.upper_profile == Profile(length=0.01, drop=1e-6)
    (tmp_path / "case.toml").write_text(case(POINTS))
    over = "geometry.upper_profile.tilt_mrad=0,2,4"
    swept = call("sweep", tmp_path / "case.toml", "--over", over, "-o", tmp_path / "out", "-q")
    assert swept.returncode == 0, swept.stderr
    rows = (tmp_path / "out" / "sweep.csv").read_text().splitlines()
    assert len(rows) == 4 and "geometry.upper_profile.tilt_mrad" in rows[0]


def test_a_result_reproduces_without_the_file(tmp_path):
    """The points belong to the case in the result: `run --from` needs no file; compare finds no difference."""
    (tmp_path / "roller.csv").write_text(FILE)
    (tmp_path / "case.toml").write_text(case('file = "roller.csv"\n'))
    first = call("run", tmp_path / "case.toml", "-o", tmp_path / "one", "--no-plots", "--json", "-q")
    assert first.returncode == 0, first.stderr
    record = json.loads(first.stdout)
    assert record["hertz_a_mm"] is None and len(record["patches"]) == 1
    assert set(record["patches"][0]) == {"y_mm", "normal_N", "force_x_N", "force_y_N", "area_mm2", "pressure_max_MPa"}
    (tmp_path / "roller.csv").unlink()
    again = call("run", "--from", tmp_path / "one" / "case.h5", "-o", tmp_path / "two", "--no-plots", "-q")
    assert again.returncode == 0, again.stderr
    same = call("compare", tmp_path / "one" / "case.h5", tmp_path / "two" / "case.h5")
    assert same.returncode == 0, same.stdout
    shown = call("show", tmp_path / "case.toml")
    assert shown.returncode == 3


def test_pictures_show_the_surfaces_and_what_has_no_limit(tmp_path):
    """Of a run and of its result file; an arc that ends beside its top is marked in the table and the file."""
    cut = "points_mm = [[-0.02, 0.0], [0.0, 0.0], [1.0, -0.01667], [2.0, -0.0667]]\n"
    (tmp_path / "cut.toml").write_text(case(cut))
    done = call("run", tmp_path / "cut.toml", "-o", tmp_path)
    assert done.returncode == 0, done.stderr
    assert "contact area / cold area" in done.stdout and "Hertz" not in done.stdout
    assert "no limit" in done.stdout and "no upper bound" in " ".join((done.stdout + done.stderr).split())
    (tmp_path / "cut_profile.png").unlink()
    assert call("plot", tmp_path / "cut.h5", "--normalised", "--fields", "profile", painted=True).returncode == 0
    assert (tmp_path / "cut_profile.png").read_bytes().endswith(b"IEND\xaeB`\x82")
    stored = read_result(tmp_path / "cut.h5").summary()
    assert "pressure_max_MPa" in stored["unbounded"] and len(stored["patches"]) == 1


def test_profiles_are_mirrored_and_smoothed():
    """Half of the amplitude is left at the wavelength of smoothing, almost all at three times that; a mirror turns y round."""
    lengths = np.linspace(-20.0, 20.0, 401)
    for wavelength, left in ((2.0, 0.5), (6.0, 81.0 / 82.0)):
        points = [[float(y), float(-1e-3 * np.cos(2.0 * np.pi * y / wavelength))] for y in lengths]
        read = Case.parse(case(f"points_mm = {points}\nsmoothing_mm = 2.0\n")).problem.geometry.upper_profile
        assert read is not None
        middle = np.array(read.points)[100:300, 1]
        assert 1e6 * np.ptp(middle) == pytest.approx(2.0 * left, rel=0.02)
    lopsided = case("points_mm = [[-2.0, -0.1], [0.0, 0.0], [1.0, -0.05]]\nmirror = true\n")
    read = Case.parse(lopsided).problem.geometry.upper_profile
    assert read is not None and read.points == ((-1e-3, -5e-5), (0.0, 0.0), (2e-3, -1e-4))


def test_noise_is_named_until_it_is_smoothed(tmp_path):
    """The picture shows the points as they were measured, from the result file, too. A straight profile is not rough."""
    curved, signs = -np.linspace(-3.0, 3.0, 61) ** 2 / 200.0, (-1.0) ** np.arange(61)
    heights = curved + 1e-3 * signs
    points = [[round(float(y), 3), float(z)] for y, z in zip(np.linspace(-3.0, 3.0, 61), heights, strict=True)]
    (tmp_path / "noise.toml").write_text(case(f"points_mm = {points}\n"))
    assert "the upper body changes sign" in " ".join(call("show", tmp_path / "noise.toml").stdout.split())
    smooth = ("--set", "geometry.upper_profile.smoothing_mm=1", "--no-plots")
    smoothed = call("run", tmp_path / "noise.toml", "-o", tmp_path, *smooth)
    assert smoothed.returncode == 0 and "changes sign" not in smoothed.stdout + smoothed.stderr
    result = read_result(tmp_path / "noise.h5")
    profile = result.problem.geometry.upper_profile
    assert 1e3 * np.array(profile.measured) == pytest.approx(np.array(points))
    (axes, *_) = profile_figure(frame_of(result)).axes
    assert "upper body before smoothing" in axes.get_legend_handles_labels()[1]
    straight = [[y / 10.0, y / 1e3] for y in range(-30, 31)]
    assert list(rough_warning("body", straight)) == [] and "100 %" in next(rough_warning("body", points))
    found = [bool(list(rough_warning("body", np.stack((np.linspace(-3.0, 3.0, 61), curved + 1e-3 * noise), axis=1))))
             for noise in np.random.default_rng(0).normal(size=(200, 61))]
    assert np.mean(found) > 0.99 and list(rough_warning("body", np.stack((np.linspace(-3.0, 3.0, 61), curved), axis=1))) == []
