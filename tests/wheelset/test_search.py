"""Where a wheel meets its rail, and with which creepages: beside CONTACT, and beside brute force."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from tests.support.sampling import sampled
from tests.support.wheelsets import ROOT, case_named, contact_cases, facing_beside, outline_points, side_of
from thermoroll_cli import Case
from thermoroll_cli.many_contacts.wheelset.curves import ProfileCurve
from thermoroll_cli.many_contacts.wheelset.first_contact import wheelset_warnings
from thermoroll_cli.many_contacts.wheelset.indentation import _grid
from thermoroll_cli.many_contacts.wheelset.kinematics import Slip, creepages, directions
from thermoroll_cli.many_contacts.wheelset.patch_surface import patches_of
from thermoroll_cli.many_contacts.wheelset.placement import Position, RailSide, WheelSide, locus
from thermoroll_cli.many_contacts.wheelset.search import Facing
from thermoroll_cli.problem.geometry import Unsolvable

JOINED = ("joined", "right y=5.0", "right y=5.0 without yaw")
"""CONTACT makes one patch of two in these cases."""


def separate() -> list[dict]:
    return [case for case in contact_cases() if not case["name"].strip().endswith(JOINED)]


@pytest.mark.slow
def test_places_angles_and_creepages_are_those_of_contact():
    seen = []
    for case in separate():
        facing, motion = facing_beside(case)
        side = side_of(case)
        found = patches_of(facing, curved=False)
        assert len(found) == len(case["contact"]["patches"]), case["name"]
        for theirs in case["contact"]["patches"]:
            patch = min(found, key=lambda patch: abs(patch.y - 1e-3 * side * theirs["y_tr"]))
            on_wheel = patch.place + patch.overlap[0] * directions(patch.angle)[2]
            c = creepages(Slip(motion, patch.position, facing.wheel.radius, tuple(on_wheel)), on_wheel, patch.angle)
            seen.append(np.abs([
                1e3 * patch.x - theirs["x_tr"], 1e3 * patch.y - side * theirs["y_tr"], 1e3 * patch.z - theirs["z_tr"],
                patch.angle - side * theirs["angle_rad"],
                c[0] - theirs["cksi"], c[1] - side * theirs["ceta"], 1e-3 * c[2] - side * theirs["cphi_rad_mm"],
            ]))  # fmt: skip
    # Millimetres, radians (CONTACT prints 1e-4) and creepages.
    assert (np.max(seen, axis=0) < [0.003, 0.003, 0.003, 1e-4, 1.2e-5, 6e-6, 1e-6]).all(), np.max(seen, axis=0)
    assert (np.median(seen, axis=0) < [5e-4, 5e-4, 5e-4, 4e-5, 1e-6, 1e-6, 1e-7]).all(), np.median(seen, axis=0)


def test_two_regions_where_contact_finds_one_or_two():
    for name in ("A2.2 right y=5.0 joined", "A2.2 right y=5.0 apart"):
        facing, _ = facing_beside(case_named(name))
        left, right = patches_of(facing, curved=True)
        assert left.high < left.ridges[1] == right.ridges[0] < right.low
        assert right.low - left.high > 1e-3
        # Between them lies a ridge; beyond them, the ends of the surfaces.
        assert (left.free_ends, right.free_ends) == ((True, False), (False, True))


@pytest.mark.parametrize("yaw", sampled([-0.03, 0.0]))
def test_the_locus_is_the_silhouette_of_the_wheel(yaw):
    """At each y the lowest point of a wheel sampled all around its lower quarter, against the line in closed form."""
    wheel = WheelSide(outline_points("MBench_S1002_v3.prw"), 0.46, 0.68, -0.07)
    position = Position(2e-3, 1e-3, -4e-3, yaw)
    _, y, z, _, _ = locus(wheel, position)
    own, r, _, _ = wheel.samples
    theta = np.linspace(-0.12, 0.12, 401)[:, None]
    surface = np.array([r * np.sin(theta), np.broadcast_to(own, (len(theta), len(own))), r * np.cos(theta)])
    points = np.tensordot(position.rotation, surface, axes=1) + position.origin(0.46)[:, None, None]
    for place in np.linspace(0.72, 0.78, 13):
        near, on_line = (np.abs(of - place) < 2e-5 for of in (points[1], y))
        # Over 20 µm a flange of 70° rises by 55 µm.
        assert np.nanmax(z[on_line]) == pytest.approx(points[2][near].max(), abs=6e-5)


def test_the_gap_is_the_distance_to_the_wheel_of_revolution():
    """Points at the gap's distance along the normals lie on the wheel, and over x the gap is smallest on the locus."""
    facing, _ = facing_beside(case_named("A2.2 right y=8.0"))
    for curved in (True, False):
        (patch,) = patches_of(facing, curved=curved)
        overlap, place = patch.overlap
        assert overlap == pytest.approx(float((-facing.gap * np.cos(facing.angle)).max()), rel=5e-3)
        s = place + np.linspace(-2e-3, 2e-3, 9)
        x = patch.x + np.linspace(-6e-3, 6e-3, 2001)
        gap = patch.gap(np.broadcast_to(x[:, None], (len(x), len(s))), s)
        np.testing.assert_allclose(gap.min(axis=0), patch.gap_on_locus(s), atol=2e-11)
        base, angle = patch.places(s), patch.inclination(s)
        rail = patch._along(patch.rail, s)
        point = base + (rail - gap[40])[:, None] * np.stack([directions(a)[2] for a in angle]) + [x[40], 0.0, 0.0]
        q = (point - facing.position.origin(0.46)) @ facing.position.rotation
        own, r, _, _ = facing.wheel.samples
        away = np.hypot(q[:, :1] * 0.0 + q[:, 1:2] - own, np.hypot(q[:, 0], q[:, 2])[:, None] - r)
        assert away.min(axis=1).max() < 2e-5  # half a step between samples


def test_a_plane_and_a_curved_patch_agree_for_small_angles():
    facing, _ = facing_beside(case_named("A2.2 left y=4.0"))
    (plane,), (curved,) = (patches_of(facing, curved=curved) for curved in (False, True))
    s, x = np.linspace(-3e-3, 3e-3, 7), np.broadcast_to(np.linspace(-3e-3, 3e-3, 5)[:, None], (5, 7))
    np.testing.assert_allclose(curved.gap(x, s), plane.gap(x, s), atol=2e-7)
    assert np.ptp(curved.inclination(s)) == pytest.approx(0.0116, abs=1e-3)


def test_a_corner_of_a_profile_stays_a_corner():
    corner = ProfileCurve(((0.0, 0.0), (1.0, 0.0), (2.0, 0.0), (3.0, 0.0), (3.0, 1.0), (3.0, 2.0), (3.0, 3.0)))
    y, z, dy, dz = corner.samples[:, ::997]
    np.testing.assert_allclose(np.minimum(abs(z), abs(y - 3.0)), 0.0, atol=1e-14)
    np.testing.assert_allclose(np.hypot(dy, dz), 1.0, rtol=1e-12)
    assert corner.corner_places.tolist() == [[3.0, 0.0]]


def test_a_steep_patch_beside_a_groove_reaches_past_its_normal():
    """A nose, a groove of 60 mm and a wing: the floor of the groove lies behind the normal of the nose's flank, which bears as
    a wheel that is 20 µm lower, at 45 degrees, overlaps it."""
    phi = np.linspace(-1.3, 1.3, 105)
    nose = [(0.015 * math.sin(at), 0.015 * (1.0 - math.cos(at))) for at in phi]
    rail = RailSide((*nose, (0.0155, 0.06), (0.04, 0.06), (0.041, 0.0), (0.09, 0.0)), 0.0, 0.0, 0.0, origin=(0.0, 0.0))
    # A line at 45 degrees that touches the nose where that is as steep, and a tread on the wing.
    height = 0.015 * (1.0 - math.sqrt(2.0))
    wheel = WheelSide(((-0.04, height + 0.04), (0.005, height - 0.005), (0.03, height - 0.005), (0.031, 0.0), (0.09, 0.0)),
                      0.46, 0.0, 0.0)
    flank, wing = patches_of(Facing(rail, wheel, Position(z=2e-5)), curved=False)
    assert wing.overlap[0] == pytest.approx(2e-5, rel=1e-3)
    assert flank.faces and flank.overlap[0] == pytest.approx(2e-5 * math.sqrt(0.5), rel=0.01)


def test_a_wheel_beside_the_rail_is_said_to_miss_it():
    facing, _ = facing_beside(case_named("A2.2 right y=8.0"))
    with pytest.raises(Unsolvable, match=r"the wheel lies between the rails: it misses its rail by 56\.8 mm"):
        _ = Facing(facing.rail, facing.wheel, Position(-0.15)).gap


def test_a_hollow_tread_is_said_to_be_hollow():
    points = [[y, z - 1.5 * max(0.0, 1.0 - (y / 20.0) ** 2)] for y, z in 1e3 * np.array(outline_points("MBench_S1002_v3.prw"))]
    case = Case.read(ROOT / "cases" / "manchester.toml")
    assert not any("hollow" in warning for warning in wheelset_warnings(case.task))
    worn = case.with_values({"wheelset.right.wheel_profile": {"points_mm": points}, "wheelset.right.nominal_radius_mm": 460.0})
    (found,) = [warning for warning in wheelset_warnings(worn.task) if "hollow" in warning]
    assert "the right wheel is hollow: its field side is 1.24 mm higher at y = 20.26 mm" in found, found


def test_tables_of_a_wheel_that_is_not_solved_are_said_to_have_no_effect():
    values = {"wheelset.left.nominal_radius_mm": 459.0, "track.left.shift_y_mm": 1.0, "track.right.shift_y_mm": 1.0}
    case = Case.read(ROOT / "cases" / "manchester.toml").with_values(values)
    assert not any("no effect" in warning for warning in wheelset_warnings(case.task))
    alone = case.with_values({"wheelset.wheels": "right"})
    found = [warning for warning in wheelset_warnings(alone.task) if "effect" in warning]
    assert found == [f"[{table}.left] has no effect: the right wheel alone is solved" for table in ("wheelset", "track")]


def test_an_overlap_that_a_table_misses_has_a_grid():
    """It lies between two places, at the end of a profile, where the fitted gap closes along."""
    s = np.linspace(-1e-3, 1e-3, 5)
    table = s, np.array([2e-6, 1e-6, 5e-7, 1e-6, 2e-6]), np.zeros(5), np.full((3, 5), -1.0)
    patch: Any = SimpleNamespace(table=table, overlap=(1e-7, 0.0), facing=SimpleNamespace(wheel=SimpleNamespace(radius=0.5)))
    grid = _grid(patch)
    assert grid.dy * (grid.ny - 2) == pytest.approx(1e-3)
    assert grid.dx * (grid.nx - 2) == pytest.approx(2.0 * math.sqrt(1e-7 * 8.0 * 0.5))
