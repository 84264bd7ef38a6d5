"""[thermal.lower] and [thermal.upper] in a case file: what they mean, and everything that can be wrong with them."""

import contextlib

import pytest

from tests.support.command_line import THERMAL
from tests.support.documents import ROOT
from thermoroll_cli.files.case import Case, CaseError, Override
from thermoroll_cli.one_contact.steady_state.derived import DerivedQuantities

SPHERES = THERMAL + '[thermal]\npartition = "matched"\n'

COOLED = "[thermal.upper]\nrecirculate = true\nconvection_W_m2K = 30.0\n"


def test_what_the_keys_mean():
    text = (SPHERES + COOLED + "width_mm = 12.0\npasses_per_revolution = 3\n"
            "[thermal.lower]\nrecirculate = false\nthermal_resistance_K_W = 1.5\n")
    heating = Case.parse(text).problem.heating
    assert heating.lower_track is None  # given, but switched off
    assert (heating.upper_track.width, heating.upper_track.passes) == (0.012, 3)
    assert (heating.upper_track.convection, heating.upper_track.resistance) == (30.0, None)
    lower = Case.parse(text, overrides=[Override.parse("thermal.lower.recirculate=true")]).problem.heating.lower_track
    assert (lower.width, lower.passes, lower.convection, lower.resistance) == (0.06, 1, None, 1.5)
    assert heating.recirculates and not Case.parse(SPHERES).problem.heating.recirculates
    mechanical = Case.parse(text, overrides=[Override.parse("thermal.heat=false")])
    assert not mechanical.problem.heating.recirculates


def test_a_case_with_them_survives_being_written():
    case = Case.parse(SPHERES + COOLED)
    assert Case.parse(case.to_toml()).problem == case.problem
    assert Case.from_json(case.to_json()).problem == case.problem
    hotter = case.with_values({"thermal.upper.thermal_resistance_K_W": 2.0}).problem.heating.upper_track
    assert (hotter.convection, hotter.resistance) == (None, 2.0)


@pytest.mark.parametrize(("old", "new"), [
    ("upper_radius_x_mm = 30.0", "upper_radius_x_mm = inf"), ('partition = "matched"', 'peclet = "stationary"'),
    ("longitudinal = 0.003", "longitudinal = 2.0"), ("upper_radius_x_mm = 30.0", "upper_radius_x_mm = -60.0"),
])
def test_a_body_that_is_said_not_to_turn_may_be_cooled_in_any_case(old, new):
    off = Case.parse(SPHERES.replace(old, new) + COOLED.replace("true", "false"))
    assert off.problem.heating.upper_track is None
    assert Case.parse(off.to_toml()).problem == Case.from_json(off.to_json()).problem == off.problem


@pytest.mark.parametrize("body", ["lower", "upper"])
def test_a_body_turns_up_to_a_creepage_of_two(body):
    """It moves at V (1 ± ξ/2) as the other one slows down or speeds up, and stands still at 2."""
    track, sign = COOLED.replace("upper", body), -1.0 if body == "lower" else 1.0
    for creepage, turns in ((1.99, True), (2.0, False), (-2.01, True)):
        text = SPHERES.replace("longitudinal = 0.003", f"longitudinal = {sign * creepage}") + track
        with contextlib.nullcontext() if turns else pytest.raises(CaseError, match=f"the {body} body stands still"):
            Case.parse(text)


def test_a_track_may_be_narrower_than_the_contact_by_less_than_an_element():
    width = 2e3 * DerivedQuantities(Case.parse(SPHERES + COOLED).problem).scales.semi_axis_y
    elements = Case.parse(SPHERES + COOLED).problem.numerics.grid[1]
    for short, fits in ((0.9, True), (1.5, False)):
        with contextlib.nullcontext() if fits else pytest.raises(CaseError, match="below that of the contact"):
            Case.parse(SPHERES + COOLED + f"width_mm = {width * (1.0 - 1.1 * short / elements)!r}\n")
    # The contact of a loaded profile is as wide as it, and an eighth of a coarse element wider where it is looked for.
    flat = Case.read(ROOT / "cases" / "twin_disc_lewis.toml", overrides=[Override.parse("numerics.grid=128")])
    assert flat.problem.heating.lower_track.width == pytest.approx(0.01)
