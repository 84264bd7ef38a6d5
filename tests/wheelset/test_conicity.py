"""Equivalent conicity: beside the benchmark of EN 15302, cones in closed form, and what changes nothing."""

from __future__ import annotations

import csv
import json
import math
from functools import cache
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg

from tests.support.command_line import call
from tests.support.documents import printed
from thermoroll_cli import conicity
from thermoroll_cli.exact.hertz import hertz_contact
from thermoroll_cli.many_contacts.wheelset.conicity import CLIMBS, ENDED, _limits, _potential
from thermoroll_cli.plots import style
from thermoroll_cli.plots.conicity_figure import draw_conicity

FOLDER = Path(__file__).parents[1] / "reference" / "conicity"


def points(name: str, every: int = 1) -> list[list[float]]:
    return np.loadtxt(FOLDER / name)[::every].tolist()


def tables(left, right, radii=(460.0, 460.0), rail=None, **wheelset):
    """A case of wheels with these outlines on both rails."""
    return {
        "material": {"youngs_modulus_GPa": 210.0, "poisson_ratio": 0.28},
        "load": {"friction_coefficient": 0.3},
        "rolling": {"speed_m_s": 1.0},
        "track": {"gauge_mm": 1435.16, "rail_profile": {"points_mm": rail or points("SUIC519A.dat")}},
        "wheelset": {
            "nominal_radius_mm": 460.0, "vertical_N": 1e5, **wheelset,
            "left": {"wheel_profile": {"points_mm": left}, "nominal_radius_mm": radii[0]},
            "right": {"wheel_profile": {"points_mm": right}, "nominal_radius_mm": radii[1]},
        },
    }  # fmt: skip


A, B = points("RUIC519A.dat"), points("RUIC519B.dat")
NORM = {"E1": (A, A), "E2": (B, B), "E5": (A, A, (460.0, 459.0)), "E9": (B, A)}
SOME = [1.0, 2.5]


@cache
def of_norm(name: str):
    return conicity(tables(*NORM[name]), np.loadtxt(FOLDER / f"ben_{name}.dat")[:, 0].tolist())


@pytest.mark.parametrize("name", ["E9", *(pytest.param(name, marks=pytest.mark.slow) for name in ("E1", "E2", "E5"))])
def test_conicity_is_within_the_tolerance_of_the_norm(name):
    reference = np.loadtxt(FOLDER / f"ben_{name}.dat")
    found = of_norm(name).conicity
    low, high = np.minimum(*reference[:, [3, 5]].T), np.maximum(*reference[:, [2, 4]].T)
    assert ((low <= found) & (found <= high)).all()
    assert np.median(np.abs(found - reference[:, 1])) < 0.003


def test_values_of_the_norm_are_as_many_as_documents_say():
    values = [np.loadtxt(FOLDER / f"ben_{name}.dat").shape[0] for name in NORM]
    count, *_ = printed("verification", "264 values of four cases")
    assert sum(values) == count.value


def cone(gamma: float) -> list[list[float]]:
    return [[-60.0, 60.0 * gamma], [60.0, -60.0 * gamma]]


def crown(radius: float) -> list[list[float]]:
    y = np.linspace(-40.0, 40.0, 81)
    return np.stack((y, radius - np.sqrt(radius**2 - y**2)), axis=1).tolist()


@pytest.mark.parametrize(("gamma", "left"), [(0.025, 459.9), pytest.param(0.1, 460.0, marks=pytest.mark.slow)])
def test_a_cone_has_its_own_conicity_on_any_rail(gamma, left):
    """Klingel: λ = 2π √(r₀ b/γ) with b half the distance of the contacts; wheels of unlike radii swing about another place."""
    shape = cone(gamma)
    found = conicity(tables(shape, shape, (left, 460.0), crown(250.0), contact_distance_mm=1400.0), [0.5, 3.0])
    np.testing.assert_allclose(found.conicity, gamma, rtol=1e-10)
    np.testing.assert_allclose(found.wavelength, 2.0 * math.pi * math.sqrt(found.mean_radius * 0.7 / gamma), rtol=1e-10)
    assert abs(found.nonlinearity) < 1e-8
    middle = np.interp(0.0, found.radius_difference, found.shifts)
    assert middle == pytest.approx(-0.5e-3 * (460.0 - left) / gamma, abs=1e-9)
    assert any("equal at a lateral shift" in warning for warning in found.warnings) == (left != 460.0)


@pytest.mark.slow
def test_exchanged_wheels_and_all_lengths_doubled_change_nothing():
    found = of_norm("E9")
    exchanged = conicity(tables(*reversed(NORM["E9"])), SOME)
    at = np.searchsorted(1e3 * found.amplitudes + 1e-9, SOME)
    np.testing.assert_allclose(exchanged.conicity, found.conicity[at], rtol=1e-9)
    there = np.interp(-exchanged.shifts[::-1], found.shifts, found.radius_difference)
    np.testing.assert_allclose(-exchanged.radius_difference[::-1], there, atol=1e-9)

    large = tables(*((2.0 * np.array(shape)).tolist() for shape in NORM["E9"]), (920.0, 920.0),
                   (2.0 * np.array(points("SUIC519A.dat"))).tolist(), flange_back_mm=-140.0, flange_back_distance_mm=2720.0)
    large["track"] |= {"gauge_mm": 2870.32, "gauge_height_mm": 28.0}
    np.testing.assert_allclose(conicity(large, [2.0 * SOME[0]]).conicity, found.conicity[at[:1]], rtol=2e-3)


@pytest.mark.slow
def test_other_samplings_and_a_mirrored_outline_change_little():
    found = of_norm("E2")
    at = np.searchsorted(1e3 * found.amplitudes + 1e-9, SOME)
    sparse = [points("RUIC519B.dat", 2)] * 2
    np.testing.assert_allclose(conicity(tables(*sparse, rail=points("SUIC519A.dat", 2)), SOME).conicity, found.conicity[at],
                               atol=2e-3)
    mirrored = tables(B, B)
    for side in ("left", "right"):
        mirrored["wheelset"][side]["wheel_profile"] = {"points_mm": [[-y, z] for y, z in B], "mirror": True}
    np.testing.assert_allclose(conicity(mirrored, SOME).conicity, found.conicity[at], rtol=1e-9)
    moved = tables(B, B, lateral_shift_mm=4.0, yaw_mrad=5.0, roll_mrad=3.0)
    np.testing.assert_allclose(conicity(moved, SOME).conicity, found.conicity[at], rtol=1e-9)


@pytest.mark.slow
def test_what_the_profiles_do_not_reach_has_no_number_and_says_so():
    found = conicity(tables(A, A), [3.0, 8.0, 9.0, 30.0])
    assert np.isnan(found.conicity).tolist() == [False, False, True, True]
    (beyond,) = [warning for warning in found.warnings if "beyond the profiles" in warning]
    assert "from 9 mm on" in beyond and beyond.endswith("at most, where a flange climbs")
    jumps = [warning for warning in found.warnings if "jumps" in warning]
    assert len(jumps) == 2 and all("6.7" in warning for warning in jumps)


@pytest.mark.slow
def test_motions_end_where_a_profile_does():
    # Beyond a trough the outer wheel becomes larger with the shift as the other one does, up to the end of the rail.
    trough = [[place, max(-0.05 * place, 0.05 * place - 1.5)] for place in np.linspace(-60.0, 60.0, 121).tolist()]
    told = conicity(tables(trough, trough, rail=crown(300.0)), [3.0, 50.0]).warnings
    assert any(text.endswith("mm at most, where a profile ends") for text in told), told


def test_what_restores_a_wheelset_ends_where_no_wheel_is_larger_any_more():
    """Δr = y (1 − y²/c²) restores the wheelset up to the shift c."""
    y = np.linspace(-0.025, 0.025, 501)
    limited = _potential(y, y * (1.0 - (y / 0.02) ** 2))
    assert limited is not None and limited.reach == pytest.approx(0.02, abs=1e-4)
    assert _limits(limited, {1: CLIMBS, -1: ENDED}) == ["no wheel is larger any more on the side it moves to"]


def test_cones_that_have_no_conicity_say_so():
    for gamma in (0.0, 0.3):
        warnings = conicity(tables(cone(gamma), cone(gamma), rail=crown(250.0)), [3.0]).warnings
        (warning,) = [text for text in warnings if "is known down to" not in text]
        assert ("there is no conicity" if gamma == 0.0 else "a wheel touches its rail where a profile ends") in warning


def test_command_writes_tables_a_picture_and_json(tmp_path):
    done = call("conicity", "cases/manchester.toml", "--amplitude", "1:12:12", "-o", tmp_path, "--json")
    assert done.returncode == 0, done.stderr
    record = json.loads(done.stdout)
    assert record["conicity_3mm"] == record["conicity"][2] == pytest.approx(0.180, abs=1e-3)
    assert record["nonlinearity_1_mm"] == pytest.approx(0.5 * (record["conicity"][3] - record["conicity"][1]), rel=1e-9)
    assert record["conicity"][-1] is None and record["amplitude_mm"] == list(range(1, 13))
    assert {Path(file).name for file in record["files"]} == {
        "manchester_conicity.csv", "manchester_shifts.csv", "manchester_contacts.csv", "manchester_conicity.png"}
    def read(name: str) -> list[dict[str, str]]:
        return list(csv.DictReader((tmp_path / name).read_text(encoding="utf-8").splitlines()))

    rows = read("manchester_conicity.csv")
    assert [float(row["conicity"] or "nan") for row in rows][:3] == record["conicity"][:3] and rows[-1]["conicity"] == ""
    shifts = read("manchester_shifts.csv")
    assert [float(row["rolling_radius_difference_mm"]) for row in shifts] == record["rolling_radius_difference_mm"]
    printed = call("conicity", "cases/manchester.toml", "-o", tmp_path, "--no-plots", "--report").stdout
    assert "conicity_3mm       0.180" in printed and "jumps" in printed
    page = (tmp_path / "manchester_conicity_report.html").read_text(encoding="utf-8")
    assert "equivalent conicity at an amplitude of 3 mm" in page and "EN 15302" in page and "±" not in page
    assert page.index("the contact of the left wheel") < page.index("Pictures")


def test_numbers_in_the_picture_stand_within_its_axes_above_the_curve(tmp_path):
    drawn: list[Any] = []
    with mock.patch.object(style, "save", lambda figure, *_: drawn.append(figure)):
        draw_conicity(tmp_path / "cones.png", conicity(tables(cone(0.1), cone(0.1), rail=crown(250.0)), [2.0, 3.0, 4.0]), "")
    FigureCanvasAgg(drawn[0]).draw()
    axes = drawn[0].axes[1]
    words = axes.texts[0].get_window_extent()
    assert "0.100 at 3 mm" in axes.texts[0].get_text()
    assert axes.transData.transform((3.0, 0.1))[1] < words.y0 and words.y1 < axes.bbox.y1
    assert axes.bbox.x0 < words.x0 and words.x1 < axes.bbox.x1


def test_points_of_contact_are_those_of_cones_on_crowns():
    """Radius, inclination and curvatures in closed form; Hertz's semi-axes at half the load; mirror images on both sides."""
    gamma, crowned = 0.05, 250.0
    found = conicity(tables(cone(gamma), cone(gamma), rail=crown(crowned), vertical_N=100e3), [3.0])
    points = found.contact_points()
    rows = [dict(zip(points, row, strict=True)) for row in zip(*points.values(), strict=True)]
    assert len(rows) == 2 * len(found.shifts)
    angle = math.atan(gamma)
    for row in rows[:: len(rows) // 8]:
        sign = 1.0 if row["side"] == "right" else -1.0
        assert row["contact_angle_mrad"] == pytest.approx(-sign * 1e3 * angle, abs=0.05)
        assert row["curvature_y_1_m"] == pytest.approx(1e3 / crowned, rel=1e-2)
        assert row["curvature_x_1_m"] == pytest.approx(1e3 * math.cos(angle) / row["rolling_radius_mm"], rel=1e-9)
        exact = hertz_contact(row["curvature_x_1_m"], 1e3 / crowned, 210e9 / (1.0 - 0.28**2) / 2.0, 50e3 / math.cos(angle))
        assert row["hertz_a_mm"] == pytest.approx(1e3 * exact.semi_axis_x, rel=1e-2)
    left, right = rows[len(rows) // 2 // 2 * 2 : len(rows) // 2 // 2 * 2 + 2]
    assert left["side"] == "left" and abs(left["contact_y_rail_mm"]) > 700.0 and right["contact_y_rail_mm"] > 700.0


def test_amplitudes_that_no_motion_has_are_not_called_beyond_the_profiles() -> None:
    """A hollow wheelset swings on one side of the middle, or around both sides with more than twice that amplitude."""
    folder = FOLDER.parent / "wheelset"
    found = conicity({
        "material": {"youngs_modulus_GPa": 210.0, "poisson_ratio": 0.28}, "load": {"friction_coefficient": 0.3},
        "rolling": {"speed_m_s": 1.0},
        "track": {"gauge_mm": 1431.889, "cant": 0.025, "rail_profile": {"file": str(folder / "uic60_true.prr")}},
        "wheelset": {"wheel_profile": {"file": str(folder / "worn_high_mileage.prw")}, "nominal_radius_mm": 460.0,
                     "vertical_N": 1e5, "flange_back_distance_mm": 1347.4, "flange_back_mm": 0.0},
    }, [2.0, 4.2, 4.6, 8.3])  # fmt: skip
    assert np.isnan(found.conicity).tolist() == [False, True, True, False]
    assert any("no motion has an amplitude of 4.2 to 4.6 mm" in warning for warning in found.warnings)
    assert not any("beyond the profiles" in warning for warning in found.warnings)
