"""Numbers that the README and the pages print are those of the program: a page is read, and what it says is solved again.

Tables between `<!-- table … -->` are written by scripts, and what the tutorial shows by `make figures`."""

from __future__ import annotations

import csv
import json
import math
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
from scipy.special import ellipe

from scripts.figures.figures_documents import run_commands
from tests.support.command_line import call
from tests.support.documents import ROOT, cell, page, printed
from thermoroll_cli import Case, conicity, solve
from thermoroll_cli.cli.cases import template_text
from thermoroll_cli.problem.result import Result


class Claim(NamedTuple):
    """What a page, or the comment of a case, says of a case with other values for some keys: scalars ("ball_1_inner.normal_N"
    of an assembly's contact), each with the text that begins with its number, and its unit over that of the scalar where they
    differ."""

    page: str
    case: str
    values: dict[str, Any]
    says: list[tuple[Any, ...]]


CLAIMS = [Claim(*claim) for claim in json.loads((ROOT / "tests" / "reference" / "claims.json").read_text(encoding="utf-8"))]


def number_of(result: Result, name: str) -> tuple[float, float]:
    """A scalar, and its estimated error."""
    contact, _, scalar = name.rpartition(".")
    record = next(each.record for each in result.contacts if each.name == contact) if contact else result.scalars
    errors = record["uncertainty"] if contact else result.uncertainty
    return record[scalar], errors.get(scalar, 0.0)


def test_what_is_claimed_stands_on_its_page() -> None:
    assert all(printed(claim.page, text) for claim in CLAIMS for _, text, *_ in claim.says)


@pytest.mark.slow
@pytest.mark.parametrize("claim", CLAIMS, ids=lambda claim: f"{claim.page}-{claim.case}")
def test_numbers_of_pages_on_the_grid_of_the_case(claim: Claim) -> None:
    """Every printed digit, also of the estimated error behind ±."""
    result = solve(Case.read(ROOT / "cases" / f"{claim.case}.toml").with_values(claim.values))
    assert result.converged, result.reason
    for name, text, *other in claim.says:
        unit, (value, error) = math.prod(other), number_of(result, name)
        first, *others = printed(claim.page, text)
        assert value / unit == pytest.approx(first.value, rel=0.0, abs=1.001 * first.rounding), (name, text)
        if "±" in text:
            assert error / unit == pytest.approx(others[0].value, rel=0.0, abs=1.001 * others[0].rounding), (name, text)


def test_the_conicity_of_the_measured_wheelset_is_that_of_its_page() -> None:
    value, rounding = printed("measured_profiles", "0.050 here. `NAME_contacts.csv`")[0]
    found = conicity(Case.read(ROOT / "cases" / "measured_wheelset.toml"), [3.0])
    assert found.conicity == pytest.approx([value], abs=rounding)


@pytest.mark.slow
def test_numbers_of_the_readme() -> None:
    result = solve(Case.parse(template_text("wheel-rail")))
    shown = re.findall(r"^  (\w+) +([\d.]+) ± ([\d.]+)", page("README"), re.MULTILINE)
    assert len(shown) == 5
    for name, value, error in shown:
        assert result[name] == pytest.approx(float(value), abs=2.0 * float(error)), name
        assert result.uncertainty[name] == pytest.approx(float(error), rel=0.3), name
    force, limit, share = printed("README", "25.0 kN of the 30 kN that friction allows; 38 % of the contact sticks")
    assert result["force_x_N"] == pytest.approx(1e3 * force.value, abs=1e3 * force.rounding)
    assert result["friction_limit_N"] == pytest.approx(1e3 * limit.value)
    assert 100.0 * result["gamma_st"] == pytest.approx(share.value, abs=share.rounding)


def test_resistances_of_the_polymer_roller_are_those_of_its_picture() -> None:
    """`make figures` writes them beside the picture; the page rounds them."""
    numbers = json.loads((ROOT / "docs" / "figures" / "numbers.json").read_text(encoding="utf-8"))["polymer roller"]
    speed, whole = printed("polymers", "0.5 m/s, with 0.5 % of the load")
    tread, thin, _ = printed("polymers", "0.4 % for the tread, 0.2 % for 2 mm")
    assert numbers["whole wheel"]["at m/s"] == pytest.approx(speed.value, abs=speed.rounding)
    for name, share in (("whole wheel", whole), ("tread of 9.5 mm", tread), ("tread of 2 mm", thin)):
        assert 100.0 * numbers[name]["largest resistance over load"] == pytest.approx(share.value, abs=share.rounding), name


def test_targets_of_coverage_that_are_missed_are_those_of_its_table() -> None:
    """`make stress` writes the table; sentences below it name what is missed."""
    table, _, below = page("verification").partition("<!-- coverage -->\n")[2].partition("<!-- end -->")
    rows = [[cell.strip(" %") for cell in line.strip("|").split("|")] for line in table.splitlines()[2:]]
    targets: dict[str, Callable[[list[str]], bool]] = {
        "Covered by less than 95 %": lambda row: float(row[3]) < 95.0,
        "More than 1 % short by three times": lambda row: float(row[4]) > 1.0,
        "Median above 12": lambda row: float(row[6]) > 12.0,
    }
    for words, misses in targets.items():
        named = below.partition(words + ": ")[2].partition(".")[0].replace("\n", " ").split(", ")
        assert named == sorted({row[0] for row in rows if misses(row)}), words
    (usual,) = printed("read_results", "98 % of the differences")
    exact = printed("verification", "3e-5 by exact solutions")[0].value
    assert exact == cell("line_contacts", "Carter's force", "largest difference")[0].value
    together = [float(row[3]) for row in rows if row[0] == "**all of these**"]
    assert together == pytest.approx([usual.value, usual.value], abs=0.6)


def test_numbers_of_the_article_are_those_of_its_figures() -> None:
    """`make figures` writes them beside the figures; sentences round them."""
    numbers = json.loads((ROOT / "docs" / "figures" / "numbers.json").read_text(encoding="utf-8"))

    def said(text: str, *values: float) -> None:
        for shown, value in zip(printed("article", text), values, strict=True):
            assert value == pytest.approx(shown.value, abs=shown.rounding), text

    here, theirs = (numbers["5"][f"V a0/kappa = {peclet}"] for peclet in ("18.8", "37.6"))
    said("0.3574 q a₀/k in the", here["exact_maximum"])
    said("0.2565 q a₀/k in theirs", theirs["exact_maximum"])
    said("0.3497 and 0.2535", here["tian_kennedy_maximum"], theirs["tian_kennedy_maximum"])
    states = [numbers["6-10"]["by speed"][speed] for speed in ("120.5 m/s", "200 m/s")]

    def rises(name: str) -> list[float]:
        return [state["with"][name] / state["without"][name] for state in states]

    said("1 to 2 % instead", *(100.0 * (1.0 - ratio) for ratio in rises("Q_F_W")))
    said("11 to 19 %", *(100.0 * (ratio - 1.0) for ratio in rises("temperature_rise_max_lower_K")))
    said("1.3 (120.5 m/s)", rises("heat_flux_max")[0], 120.5)
    said("1.26 p₀ (200 m/s)", rises("gamma_p")[1], 200.0)
    assert numbers["11"]["runs"]["longitudinal"]["0.001"]["gamma_p"] > 1.0 and "exceeds p₀ already at 0.001" in page("article")
    cold = next(row for row in numbers["6-10"]["velocities"]["rows"] if row[1] == "1" and "rolling" in row[0])
    said("0.0564 W, as CONTACT", float(cold[2]))


@pytest.mark.slow
def test_the_tutorial_shows_what_its_commands_print(tmp_path: Path) -> None:
    """`make figures` inserts it. Words are equal, numbers within 2 %; the line of what a run takes depends on the machine."""
    (tmp_path / "figures").mkdir()
    (tmp_path / "tutorial.md").write_text(page("tutorial"), encoding="utf-8")
    run_commands(tmp_path / "tutorial.md")
    fresh, shown = (text.splitlines() for text in ((tmp_path / "tutorial.md").read_text(encoding="utf-8"), page("tutorial")))
    number = r"\d+(?:\.\d+)?(?:e-?\d+)?"
    for new, old in zip(fresh, shown, strict=True):
        if "MiB" not in old:
            assert re.sub(number, "#", new).split() == re.sub(number, "#", old).split()
            there, here = ([float(each) for each in re.findall(number, line)] for line in (new, old))
            assert there == pytest.approx(here, rel=0.02), old


@pytest.mark.slow
def test_how_much_softer_clean_dry_steel_is_follows_from_the_interlayers() -> None:
    """At a hundredth of a per cent of slip, with the interlayers that were fitted and without."""
    values = {"creepage.longitudinal": 1e-4, "numerics.grid": 32, "thermal.heat": False}
    rigs = printed("verification", "24 and 30 % on the first two rigs")
    for shown, name in zip(rigs, ("vt_fra_roller_rig", "twin_disc_lewis"), strict=True):
        case = Case.read(ROOT / "cases" / f"{name}.toml")
        soft, smooth = (solve(case.with_values({**values, **layer}))["force_x_N"]
                        for layer in ({}, {"layer.compliance_um_GPa": 0.0}))
        assert 100.0 * (1.0 - soft / smooth) == pytest.approx(shown.value, abs=0.5)
    for shown, row in zip(printed("verification", "1 to 4 µm/GPa on clean steel, 150 on a dirty rail"),
                          ("interlayer", "creep curve, interlayer", "layer, falling friction, memory, given"), strict=True):
        assert cell("verification", row, "interlayer (µm/GPa)")[0].value == pytest.approx(shown.value, abs=shown.rounding), row


# --- calculations by hand -------------------------------------------------------------------------------------------------


def says(name: str, text: str, *values: float) -> None:
    """The first numbers of `text` on a page are `values` in its digits."""
    for (shown, rounding), value in zip(printed(name, text)[: len(values)], values, strict=True):
        assert value == pytest.approx(shown, rel=0.0, abs=1.001 * rounding), (text, shown)


def test_the_gear_pair_by_hand() -> None:
    radius, modulus, load, friction = 6.0, 206e3 / (2.0 * 0.91), 12.5, 0.06
    half = math.sqrt(4.0 * load * radius / (math.pi * modulus))
    saturation = friction * half / radius
    stick = 1.0 - 2e-4 / saturation
    says("line_contacts", "113.2 GPa", 1e-3 * modulus)
    says("line_contacts", "0.0290 mm; p₀", half)
    says("line_contacts", "274 MPa. 3. All", 2.0 * load / (math.pi * half))
    says("line_contacts", "2.90e-4 on", saturation)
    says("line_contacts", "0.311 sticks", stick)
    says("line_contacts", "0.677 N/mm (Carter", friction * load * (1.0 - stick**2))
    says("line_contacts", "0.75 N/mm, and the heat is FVξ = 0.45 W", friction * load, friction * load * 3.0 * 0.2)
    effusivity = 46.6 / math.sqrt(12.5e-6)
    says("line_contacts", "13.2 kJ/(m² K √s)", 1e-3 * effusivity)

    def flash(speed: float) -> float:
        roots = effusivity * (math.sqrt(1.1 * speed) + math.sqrt(0.9 * speed))
        return 1.11e3 * friction * load * 0.2 * speed / (roots * math.sqrt(2e-3 * half))

    says("line_contacts", "1.44 K at 3 m/s", flash(3.0))
    says("line_contacts", "6.43 K at 60 m/s", flash(60.0))


def test_the_bearing_by_hand() -> None:
    """What its race control gives is in claims.json."""
    ball, pitch = 22.225e-3, 125.26e-3
    mass = 7800.0 * math.pi * ball**3 / 6.0
    says("bearing", "1.0312 mm. At rest", 1e3 * (2.0 * 0.5232 - 1.0) * ball)
    says("bearing", "44.8 g is 614 N", 1e3 * mass, 0.5 * mass * pitch * (0.4464e4 * math.pi / 30.0) ** 2)
    record = solve(Case.read(ROOT / "cases" / "angular_contact.toml").with_values({"bearing.inner_rpm": 0.0})).patches[0].record
    says("bearing", "41.50°: each carries", record["contact_angle_deg"])
    says("bearing", "1678.9 N", record["normal_N"])


def test_the_wheel_and_the_coated_ball_by_hand() -> None:
    wheel = solve(Case.read(ROOT / "cases" / "wheel_rail.toml").with_values({"numerics.grid": 24, "thermal.heat": False}))
    a, b = wheel["hertz_a_mm"], wheel["hertz_b_mm"]
    says("examples", "5.911 mm · 10.575 mm) = 763.8 MPa", a, b, 1.5e5 / (math.pi * a * b))
    saturation = 9e4 / (4.0 * 82e3 * a * b)
    says("examples", "62.5 mm²) = 0.0044", a * b)
    says("examples", "0.0044 | |", saturation)
    says("examples", "25.2 kN | 24.76", 30.0 * (1.0 - (1.0 - 0.002 / saturation) ** 3))
    force, spin = printed("examples", "49.6 N + 0.4 N")
    assert 30.0 * (force.value + spin.value) == pytest.approx(printed("examples", "1500 W; at most μWVξ_x = 1800 W")[0].value)
    ball = Case.read(ROOT / "cases" / "coated_ball.toml")
    bare = solve(Case.from_dict({**{key: value for key, value in json.loads(ball.to_json()).items() if key != "subsurface"},
                                 "material": without_layers(ball)}).with_values({"numerics.grid": 16}))
    a, b, peak = (bare[name] for name in ("hertz_a_mm", "hertz_b_mm", "hertz_p0_MPa"))
    says("examples", "0.0541 mm, 0.524 mm, 842 MPa", a, b, peak)
    says("examples", "1.0 N mm | 0.083", 0.375 * 5.0 * b * float(ellipe(1.0 - (a / b) ** 2)))
    saturation = 3.0 * 5.0 / (4.0 * 210e3 / 2.6 * a * b)
    says("examples", "0.00164)³] = 3.3 N", saturation, 5.0 * (1.0 - (1.0 - 0.0005 / saturation) ** 3))
    tension = peak * ((1.0 - 2.0 * 0.3) / 3.0 + math.pi * 0.1 * 4.3 / 8.0)
    says("examples", "254 MPa, times E_coating/E_steel = 1.19: 303 MPa", tension, 250.0 / 210.0, tension * 250.0 / 210.0)


def without_layers(case: Case) -> dict[str, Any]:
    material = json.loads(case.to_json())["material"]
    return {body: {key: value for key, value in keys.items() if key != "layers"} for body, keys in material.items()}


def test_the_polymer_roller_by_hand() -> None:
    roller = Case.read(ROOT / "cases" / "polymer_roller.toml")
    ((tread),) = json.loads(roller.to_json())["material"]["upper"]["layers"]
    half, omega = 6.4e-3, 1.5 / 6.4e-3
    says("polymers", "4.3 ms. At", 1e3 * half / 1.5)
    says("polymers", "234 1/s", omega)
    stored = 1.0 - sum(share / (1.0 + (omega * time) ** 2) for share, time in tread["relaxation"])
    lost = sum(share * omega * time / (1.0 + (omega * time) ** 2) for share, time in tread["relaxation"])
    says("polymers", "0.63$ and", stored)
    says("polymers", "0.070$: a loss tangent of 0.11", lost, lost / stored)
    says("polymers", "9.6 N. 3.", 3.0 / 16.0 * 800.0 * half / 0.1)
    says("polymers", "0.35: 3.3 N", math.pi * lost / stored, 9.6 * math.pi * lost / stored)


@pytest.mark.slow
def test_the_contact_of_the_polymer_roller() -> None:
    contact = solve(Case.read(ROOT / "cases" / "polymer_roller.toml"))
    inside = contact.fields["pressure"] > 0.0
    for text, axis, places in (("12.8 mm long", 1, contact.x), ("32 mm wide", 0, contact.y)):
        (length,) = printed("polymers", text)
        step = 1e3 * float(places[1] - places[0])
        assert np.count_nonzero(inside.any(axis=axis)) * step == pytest.approx(length.value, abs=2.0 * step)


# --- contacts over time and wear ------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_the_corrugated_rail() -> None:
    """Force and heat of the last wave beside the steady state of each row: sines of its length, fitted."""
    case = Case.read(ROOT / "cases" / "corrugation.toml")
    history = solve(case).history
    assert history is not None
    last = np.array(history["distance_mm"]) >= 80.0 - 1e-6
    settings = (ROOT / "cases" / "corrugation.toml").read_text(encoding="utf-8").partition("[history]")[0]
    constant = Case.parse(f"{settings}[creepage]\nlongitudinal = 0.0")
    steady = [solve(constant.with_values({"load.normal_N": load, "creepage.longitudinal": creepage}))
              for load, creepage in zip(history["load.normal_N"], history["creepage.longitudinal"], strict=True)]
    wave = 2.0 * math.pi / 40.0 * np.array(history["distance_mm"])[last]
    shapes = np.stack([np.ones_like(wave), np.cos(wave), np.sin(wave)], axis=1)

    def sine(values: list[float]) -> tuple[float, complex]:
        mean, cosine, sinus = np.linalg.lstsq(shapes, np.array(values)[last], rcond=None)[0]
        return float(mean), complex(cosine, sinus)

    shown = iter(printed("record_over_time", """±2.84 kN about 10.6 kN: 71 % of what steady solutions give, and 44° later along
                                             the wave; the frictional heat has 59 % and is 79° later"""))
    for name in ("force_x_N", "Q_F_W"):
        (mean, there), (_, quiet) = sine(history[name]), sine([result[name] for result in steady])
        ratio = there / quiet
        found = [100.0 * abs(ratio), math.degrees(math.atan2(ratio.imag, ratio.real))]
        for value in ([1e-3 * abs(there), 1e-3 * mean] if name == "force_x_N" else []) + found:
            text = next(shown)
            assert value == pytest.approx(text.value, rel=0.0, abs=1.001 * text.rounding)
    (worst,) = printed("record_over_time", "1.5 % of μW for the force")
    errors = 100.0 * np.array(history["uncertainty.force_x_N"]) / np.array(history["friction_limit_N"])
    assert errors.max() == pytest.approx(worst.value, abs=worst.rounding)


def test_the_record_that_is_shown_is_the_beginning_of_the_file() -> None:
    (shown,) = re.findall(r"```text\n(.*?)```", page("record_over_time"), re.DOTALL)
    assert (ROOT / "cases" / "corrugation.csv").read_text(encoding="utf-8").startswith(shown)


@pytest.mark.slow
def test_the_worn_measured_wheel(tmp_path: Path) -> None:
    case = ROOT / "cases" / "measured_wheelset.toml"
    done = call("wear", case, "--set", "numerics.grid=16", "--no-plots", "-o", tmp_path)
    assert done.returncode == 0, done.stderr
    with (tmp_path / "measured_wheelset_wear.csv").open(encoding="utf-8") as file:
        new, *_, worn = csv.DictReader(file)
    mass, mass_error, depth, depth_error, *_ = printed(
        "measured_profiles", "0.11 ± 0.01 kg and 0.37 ± 0.06 mm in 10,000 km, and the conicity rises from 0.05 to 0.13")
    *_, before, after = printed("measured_profiles", "the conicity rises from 0.05 to 0.13")
    for name, unit, shown, error in (("worn_mass_wheel_right_kg", 1.0, mass, mass_error),
                                     ("depth_max_wheel_right_um", 1e3, depth, depth_error)):
        assert float(worn[name]) / unit == pytest.approx(shown.value, abs=shown.rounding), name
        assert float(worn[f"uncertainty.{name}"]) / unit == pytest.approx(error.value, abs=error.rounding), name
    assert float(new["conicity_3mm"]) == pytest.approx(before.value, abs=before.rounding)
    assert float(worn["conicity_3mm"]) == pytest.approx(after.value, abs=after.rounding)
