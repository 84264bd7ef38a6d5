"""Rails that change along the track and wheels that are not round, from slices: beside round wheels on straight rails, exact
geometry, mirror images and shifts."""

from __future__ import annotations

import itertools
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from scripts.stress.tracks import check, random_track
from tests.support.command_line import call
from tests.support.documents import ROOT
from thermoroll_cli import Case, CaseError, Result, conicity, solve, wear
from thermoroll_cli.files.profile_file import read_slices
from thermoroll_cli.many_contacts.wheelset.first_contact import facts_of, touching
from thermoroll_cli.many_contacts.wheelset.slices import Slices

R, CROWN = 460.0, 300.0
"""Radii in mm of the wheel, a cylinder, and of the rail's top, which is an arc."""
Y = np.linspace(-30.0, 30.0, 121)


def rail(z: float = 0.0, y: float = 0.0) -> list[list[float]]:
    return np.stack((Y + y, Y**2 / (2.0 * CROWN) + z), axis=1).tolist()


def wheel(radius: float) -> list[list[float]]:
    return [[float(y), radius - R] for y in np.linspace(-40.0, 40.0, 21)]


def sections(places: Any, outlines: list[list[list[float]]]) -> dict[str, Any]:
    return {"flip": False, "sections": [{"at": float(at), "points_mm": points}
                                        for at, points in zip(places, outlines, strict=True)]}  # fmt: skip


def tables(rail_profile: dict[str, Any], wheel_profile: dict[str, Any], side: str = "right", **wheelset: Any) -> dict[str, Any]:
    load = {} if "height_mm" in wheelset else {"vertical_N": 2e4}
    return {"material": {"youngs_modulus_GPa": 210.0, "poisson_ratio": 0.28}, "load": {"friction_coefficient": 0.3},
            "rolling": {"speed_m_s": 2.0}, "numerics": {"grid": 12},
            "track": {"rail_profile": rail_profile, side: {"origin_mm": [750.0, 0.0]}},
            "wheelset": {"wheel_profile": wheel_profile, "wheels": side, "nominal_radius_mm": R, "flange_back_mm": -70.0,
                         "flange_back_distance_mm": 1360.0, "roll_mrad": 0.0, "angular_velocity_rad_s": 2e3 / R * 1.002,
                         **load, **wheelset}}  # fmt: skip


PLAIN = {"points_mm": rail(), "flip": False}, {"points_mm": wheel(R), "flip": False}
NOSE = sections(np.arange(-100.0, 101.0, 50.0), [rail(-0.1 * s) for s in np.arange(-100.0, 101.0, 50.0)])


def flat(length: float) -> dict[str, Any]:
    """A wheel with a flat of this length (mm) at the angle 0, the chord of its circle."""
    half, degrees = math.asin(0.5 * length / R), np.linspace(-6.0, 6.0, 121)
    radii = np.where(np.abs(np.radians(degrees)) < half, R * math.cos(half) / np.cos(np.radians(degrees)), R)
    return sections(degrees, [wheel(float(radius)) for radius in radii])


@pytest.mark.parametrize("patches", ["planar", pytest.param("curved", marks=pytest.mark.slow)])
def test_slices_that_are_all_the_same_are_the_plain_track(patches: str) -> None:
    """And a wheel that is round all the way. Slices that differ far away alone are it as nearly as 8 elements show."""
    def solved(*profiles: dict[str, Any]) -> Result:
        return solve(Case.from_dict(tables(*profiles, patches=patches, height_mm=0.05) | {"numerics": {"grid": 8}}))

    plain = solved(*PLAIN)
    for far, near in ((0.0, 1e-9), (1.0, 1e-3)):
        sliced = solved(sections((-50.0, 0.0, 20.0, 90.0, 800.0), [*4 * [rail()], rail(far)]),
                        sections((-20.0, 0.0, 30.0), 3 * [wheel(R)]))
        assert plain.converged and sliced.converged, sliced.reason
        for name in ("track_force_x_N", "track_force_z_N", "pressure_max_MPa", "Q_F_W"):
            assert sliced[name] == pytest.approx(plain[name], rel=near, abs=1e-12), name


def test_a_wheel_climbs_a_nose_ahead_of_its_axle() -> None:
    """On a rail that rises 1:10 the contact lies ahead by R sin α, at the height R/cos α − R; its pressure pushes the wheel
    back by N sin α, and the axle, which follows the rise, moves by 1/cos α faster than it. A place further on is higher."""
    angle = math.atan(0.1)
    task = Case.from_dict(tables(NOSE, PLAIN[1])).task
    facing = touching(task)["right"]
    k = int(np.argmin(facing.gap))
    assert 1e3 * facing.ahead[k] == pytest.approx(R * math.sin(angle), abs=0.02)
    assert 1e3 * facing.position.z == pytest.approx(R - R / math.cos(angle), abs=2e-4)
    further = touching(Case.from_dict(tables(NOSE, PLAIN[1], position_mm=12.5)).task)["right"]
    assert further.position.z == pytest.approx(facing.position.z - 1.25e-3, abs=1e-8)
    here = solve(Case.from_dict(tables(NOSE, PLAIN[1])))
    assert here.converged, here.reason
    (patch,) = here.patches
    assert patch.record["x_mm"] == pytest.approx(R * math.sin(angle), abs=0.05)
    along, normal = patch.record["force_x_N"], patch.record["normal_N"]
    assert here["track_force_x_N"] == pytest.approx(along * math.cos(angle) + normal * math.sin(angle), rel=1e-6)
    assert here["track_force_z_N"] == pytest.approx(2e4, rel=1e-4)
    assert patch.record["creepage_x"] == pytest.approx(1.002 - 1.0 / math.cos(angle), rel=0.02)
    assert here["power_balance_error"] < 2e-3
    (number,) = here.plot("gap").axes[0].texts
    assert number.get_text() == "1" and number.xy == (patch.record["y_mm"], patch.record["x_mm"])


@pytest.mark.slow
def test_a_mirrored_track_mirrors_the_forces() -> None:
    """A rail that moves sideways along the track, under a right wheel and as its mirror image under a left one."""
    places = np.arange(-60.0, 61.0, 40.0)
    moved = sections(places, [rail(-0.05 * s, 0.1 * s) for s in places])
    right, left = (solve(Case.from_dict(tables(moved, PLAIN[1], side, height_mm=0.05) | {"numerics": {"grid": 8}}))
                   for side in ("right", "left"))
    assert right.converged, right.reason
    assert abs(right["track_force_y_N"]) > 10.0
    for axis, sign in (("x", 1.0), ("y", -1.0), ("z", 1.0)):
        assert left[f"track_force_{axis}_N"] == pytest.approx(sign * right[f"track_force_{axis}_N"], rel=1e-9)


@pytest.mark.slow
def test_the_axle_over_a_flat_is_as_high_as_its_chord() -> None:
    """Until elastic: on the middle of a flat of 40 mm the axle is R cos φ above the rail, on its edge R, and at each angle in
    between the edge lies ahead or behind; the rotation passes it on."""
    chord = R * (1.0 - math.cos(math.asin(20.0 / R)))
    for degrees, expected in ((0.0, chord), (4.0, 0.0)):
        facing = touching(Case.from_dict(tables(PLAIN[0], flat(40.0), rotation_deg=degrees)).task)["right"]
        assert 1e3 * facing.position.z == pytest.approx(expected, abs=2e-3), degrees
    half = math.degrees(math.asin(20.0 / R))
    facing = touching(Case.from_dict(tables(PLAIN[0], flat(40.0), rotation_deg=0.5 * half)).task)["right"]
    # The edge has turned by as much from below the axle.
    assert 1e3 * facing.position.z == pytest.approx(R * (1.0 - math.cos(math.radians(0.5 * half))), abs=5e-3)


@pytest.mark.slow
def test_all_of_a_flat_bears() -> None:
    result = solve(Case.from_dict(tables(PLAIN[0], flat(40.0))))
    round_one = solve(Case.from_dict(tables(*PLAIN)))
    assert result.converged, result.reason
    (patch,) = result.patches
    loaded = patch.x[np.asarray(patch.fields["pressure"]).any(axis=1)]
    assert np.ptp(loaded) == pytest.approx(0.04, rel=0.15), "all of the flat bears"
    assert result["contact_area_mm2"] > 2.0 * round_one["contact_area_mm2"]


def test_the_surface_between_slices() -> None:
    """Of a rail that is a parabola along the track of radius R: through the slices it is that everywhere; with slices as
    control points h apart cubic B-splines lie h²/(6 R) inside of it. A jump of their lengths, an interruption, disturbs
    none."""
    step, radius = 0.02, 5.0
    at = tuple(step * k for k in range(12))
    outlines = tuple(((-0.02, s**2 / (2.0 * radius)), (0.02, s**2 / (2.0 * radius))) for s in at)
    wide = tuple(((-0.1, 0.3), (0.1, 0.3)) for _ in range(3))
    for control, inside in ((False, 0.0), (True, step**2 / (6.0 * radius))):
        slices = Slices(at, outlines, control=control)
        interrupted = Slices((*at, 0.24, 0.26, 0.28), outlines + wide, control=control)
        for s in (0.1, 0.1037, 0.187):
            for surface in (slices, interrupted):
                assert surface.lines_at(s)[0, 1] == pytest.approx(s**2 / (2.0 * radius) + inside, abs=1e-12), (control, s)


def test_a_part_that_begins_ends_where_its_first_slice_is() -> None:
    """Features of all slices; the second part exists from 10 mm on."""
    short, whole = ((0.0, 0.0), (0.02, 0.0)), ((0.0, 0.0), (0.02, 0.0), (0.03, -0.01))
    end = 0.02 + math.hypot(0.01, 0.01)
    slices = Slices((0.0, 0.01, 0.02), (short, whole, whole), ((0.0, 0.02, -1e-3), (0.0, 0.02, end), (0.0, 0.02, end)))
    assert slices.lines_at(0.005)[:, 0][~np.isnan(slices.lines_at(0.005)[:, 0])].max() == pytest.approx(0.02)
    assert slices.outline_at(0.01)[-1] == pytest.approx((0.03, -0.01))
    assert slices.outline_at(0.015)[-1] == pytest.approx((0.03, -0.01))


@pytest.mark.slow
def test_a_rail_that_begins_under_the_wheel_bears_from_there_on() -> None:
    """Behind its first slice there is nothing: the pressure ends there, at a given height, and the rest bears less than the
    whole; 30 mm further the beginning is not noticed."""
    lower, end = [[-60.0, 20.0], [-35.0, 20.0]], 25.0
    whole = math.dist(lower[1], rail()[0]) + sum(itertools.starmap(math.dist, itertools.pairwise(rail())))
    begins = {"flip": False, "sections": [
        {"at": at, "points_mm": lower + (rail() if at >= 0.0 else []),
         "features_mm": [0.0, end, end + whole if at >= 0.0 else -1.0]}
        for at in (-100.0, -50.0, 0.0, 50.0, 100.0)]}  # fmt: skip
    # What touches ahead is told of, which the rail below the axle lacks.
    facts = facts_of(Case.from_dict(tables(begins, PLAIN[1], position_mm=-5.0)).task)
    assert facts["first_contact_y_rail_right_mm"] == pytest.approx(0.0, abs=0.1)
    there, here, plain = (solve(Case.from_dict(tables(profile, PLAIN[1], height_mm=0.05, **at))) for profile, at in (
        (begins, {"position_mm": 30.0}), (begins, {"position_mm": 1.0}), (PLAIN[0], {})))
    assert here.converged, here.reason
    (patch,) = here.patches
    lines = np.asarray(patch.fields["pressure"]).sum(axis=1)
    ahead = patch.record["x_mm"] - 1e3 * (patch.x - lines @ patch.x / lines.sum())
    assert there["track_force_z_N"] == pytest.approx(plain["track_force_z_N"], rel=2e-3)
    assert 0.5 < here["track_force_z_N"] / plain["track_force_z_N"] < 0.9
    element = float(np.abs(np.diff(ahead)).max())
    assert ahead[lines > 0.0].min() == pytest.approx(-1.0, abs=0.5 * element + 0.2)


def test_a_patch_beside_the_end_of_a_rail_that_moves_aside_is_solved() -> None:
    """On some lines next to it there is no rail all along. The load is carried within the errors of its rules."""
    found = check(random_track(2))
    assert found.converged and not found.broken, found


@pytest.mark.slow
@pytest.mark.parametrize("history", [None, {"distance_mm": [0, 4], "steps": 2}])
def test_rounded_slices_are_told_and_counted(history: dict[str, Any] | None) -> None:
    """A rail of R 300 that rises and bends, at every 0.5 mm in slices of 10 mm, with three decimals: 720.5 MPa without rounding
    lie within ±. Points of a slice are rounded, and slices on a line along the rail are, by 1 µm/√12 each."""
    places = np.arange(-100.0, 101.0, 10.0)
    rounded = sections(places, [np.round(np.array(rail(2.13e-5 * s**2 - 0.02 * s)), 3).tolist() for s in places])
    case = Case.from_dict(tables(rounded, PLAIN[1]) | {"numerics": {"grid": 16 if history else 24}}
                          | ({"history": history} if history else {}))
    result = solve(case)
    error = result.uncertainty["pressure_max_MPa"]
    assert 10.0 < abs(result["pressure_max_MPa"] - 720.5) < error < 300.0
    assert result.patches[0].uncertainty["pressure_max_MPa"] == pytest.approx(error, rel=0.05)
    assert any("right rail has points 0.5 mm apart that are rounded" in each for each in result.warnings)
    across, along = result.patches[0].problem.geometry.rounded
    assert (across.spacing, along.spacing) == pytest.approx((5e-4, 1e-2), rel=1e-3)
    for each in (across, along):
        assert 0.5 < each.error / (1e-6 / math.sqrt(12.0)) < 1.01


SLCS = (ROOT / "tests" / "reference" / "synthetic_profiles" / "nose.slcs").read_text()


def test_files_of_slices_are_read_shown_and_kept_in_the_case(tmp_path: Path) -> None:
    for name, z in (("a", 0.0), ("b", -1.0)):
        (tmp_path / f"{name}.csv").write_text("\n".join(f"{y} {height}" for y, height in rail(z)))
    (tmp_path / "nose.slcs").write_text(SLCS)
    (first, second), control = read_slices(tmp_path / "nose.slcs")
    assert not control
    assert (first.at, second.at) == (10.0, 30.0) and second.features == [0.0, 30.0, 60.5] and first.features[-1] == -1.0
    (tmp_path / "nose.slcs").write_text(SLCS.replace("  3 1 0", "  0 0 0"))
    content = tables({"file": str(tmp_path / "nose.slcs"), "flip": False}, PLAIN[1], position_mm=20.0)
    case = Case.from_dict(content)
    assert min(z for _, z in case.task.rails["right"].profile) == pytest.approx(-0.5e-3, abs=1e-6)
    assert Case.parse(case.to_toml()).task == case.task and Case.from_json(case.to_json()).task == case.task
    listed = tables({"slices": [[10.0, str(tmp_path / "a.csv")], [30, str(tmp_path / "b.csv")]], "flip": False}, PLAIN[1],
                    position_mm=20.0)  # fmt: skip
    assert Case.from_dict(listed).task == case.task
    (tmp_path / "case.toml").write_text(case.to_toml())
    assert "first_contact_height_mm" in call("show", tmp_path / "case.toml").stdout
    assert "the first of 2 slices from 10 to 30 mm" in str(case.profiles)


def test_rollers_and_commands_that_need_the_same_rail_everywhere_refuse_slices() -> None:
    content = tables(NOSE, PLAIN[1])
    with pytest.raises(CaseError, match="have no slices"):
        Case.from_dict({**content, "track": {**content["track"], "roller_radius_mm": 500.0}})
    content["wheelset"]["wheels"] = "both"
    for key in ("roll_mrad", "angular_velocity_rad_s"):
        del content["wheelset"][key]
    for ask in (lambda: conicity(Case.from_dict(content)), lambda: wear(Case.from_dict({**content, "wear": {
            "distance_km": 1.0, "lower": {"specific_wear_rate_mm3_Nm": 1e-5, "track_length_m": 1.0}}}))):  # fmt: skip
        with pytest.raises((ValueError, CaseError), match="knows no slices"):
            ask()
