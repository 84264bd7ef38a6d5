"""Pictures of runs: which there are, the units, words and limits they show, and what must not break them."""

from __future__ import annotations

import dataclasses
import os
import pathlib
import subprocess
import sys
import warnings
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from matplotlib.collections import LineCollection
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure

from tests.support import synthetic
from tests.support.command_line import MECHANICAL, PATIENCE, THERMAL
from tests.support.scenes import article_4_1, solved, wheel_on_rail
from thermoroll_cli.files.case import Case
from thermoroll_cli.files.result.outcome import read_result, write_result
from thermoroll_cli.plots import style as plot_style
from thermoroll_cli.plots.maps import CONTACT, STICK
from thermoroll_cli.plots.pictures import KINDS, draw, figure
from thermoroll_cli.plots.run_frame import WITH, WITHOUT, borders_of, frame_of, limits_of, unit_for
from thermoroll_cli.plots.style import readable
from thermoroll_cli.problem.friction import Interlayer
from thermoroll_cli.problem.names import QUANTITIES, SCALARS
from thermoroll_cli.problem.result import Result
from thermoroll_cli.problem.scalar_errors import row_of, scalar_text
from thermoroll_cli.python_api import solve

ALL = ["pressure", "traction", "heat_flux", "temperature", "centreline", "summary"]


@pytest.fixture(autouse=True)
def coarse(monkeypatch: pytest.MonkeyPatch) -> None:
    """Few pixels: rendering is what takes the time."""
    monkeypatch.setattr(plot_style, "DPI", 40)


def kinds(paths: list[pathlib.Path], stem: str) -> list[str]:
    return [path.stem.removeprefix(stem + "_") for path in paths]


def shown(result: Result, kind: str, **options: Any) -> Figure:
    picture = figure(result, kind, **options)
    assert picture is not None
    return picture


def titles(picture: Figure) -> list[str]:
    return [axes.get_title() for axes in picture.axes if axes.get_title()]


def legend(picture: Figure) -> list[str]:
    return [text.get_text() for text in picture.legends[0].get_texts()]


def with_fields(result: Result, **fields: Any) -> Result:
    state = dataclasses.replace(result.coupled, fields={**result.coupled.fields, **fields})
    return dataclasses.replace(result, coupled=state, isothermal=state)


# Which pictures there are, and their files


@pytest.mark.parametrize(("options", "missing"), [
    *(pytest.param(*row, marks=pytest.mark.slow) for row in (({}, set()), ({"heat": False}, {"heat_flux", "temperature"}))),
    ({"tangential": False}, {"heat_flux", "temperature", "traction"}),
])
def test_stages_that_were_skipped_have_no_picture(options: dict[str, Any], missing: set[str]) -> None:
    result = synthetic.result((12, 12), **options)
    assert [kind for kind in KINDS if figure(result, kind) is not None] == [name for name in ALL if name not in missing]


@pytest.mark.slow
def test_a_stored_result_gives_the_same_pictures(tmp_path: pathlib.Path) -> None:
    result = synthetic.result((24, 20), aspect=1.5)
    write_result(tmp_path / "r.h5", result)
    wanted = ["centreline"]
    direct = draw(result, tmp_path / "direct", kinds=wanted, dpi=40)
    assert kinds(direct, "direct") == wanted
    assert sorted(os.listdir(tmp_path)) == sorted(["r.h5", *(path.name for path in direct)])
    stored = draw(read_result(tmp_path / "r.h5"), tmp_path / "stored", kinds=wanted, dpi=40)
    assert [path.read_bytes() for path in direct] == [path.read_bytes() for path in stored]


@pytest.mark.slow
def test_every_format_is_reproducible(tmp_path: pathlib.Path) -> None:
    result = synthetic.result((16, 16), deformation=False)
    wanted: dict[str, Any] = {"kinds": ["traction"], "formats": ["png", "svg", "pdf"]}
    for first, second in zip(draw(result, tmp_path / "a", **wanted), draw(result, tmp_path / "b", **wanted), strict=True):
        content = first.read_bytes()
        assert content.startswith({".png": b"\x89PNG", ".svg": b"<?xml", ".pdf": b"%PDF"}[first.suffix])
        assert content == second.read_bytes()


@pytest.mark.slow
def test_an_odd_title_is_written(tmp_path: pathlib.Path) -> None:
    result = synthetic.result((16, 16), title=ODD[0][1]["title"])
    assert len(draw(result, tmp_path / "a", kinds=["pressure"], formats=["png", "svg", "pdf"])) == 3


def test_text_in_svg_is_text(tmp_path: pathlib.Path) -> None:
    (path,) = draw(synthetic.result((16, 16)), tmp_path / "a", kinds=["pressure"], formats=["svg"])
    assert f"{WITHOUT}, max" in path.read_text() and "pressure p (MPa)" in path.read_text()


def test_a_picture_that_cannot_be_written_says_so(tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(OSError, match=r"cannot write .*a_pressure\.png: No such file or directory"):
        draw(synthetic.result((8, 8)), tmp_path / "absent" / "a")

    def interrupt(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("thermoroll_cli.tools.atomic.os.replace", interrupt)
    with pytest.raises(KeyboardInterrupt):
        draw(synthetic.result((8, 8)), tmp_path / "a")
    assert os.listdir(tmp_path) == []


@pytest.mark.slow
def test_the_resolution_and_size_for_print(tmp_path: pathlib.Path) -> None:
    from PIL import Image

    result = synthetic.result((16, 16), deformation=False)
    for options, dpi in (({}, 40), ({"dpi": 120}, 120)):
        with Image.open(draw(result, tmp_path / "a", kinds=["pressure"], **options)[0]) as image:
            assert image.info["dpi"] == pytest.approx((dpi, dpi), abs=0.1)
            assert image.width == pytest.approx(90 / 25.4 * dpi, abs=1), "one column"
    assert shown(synthetic.result((16, 16)), "pressure").get_size_inches()[0] == pytest.approx(180 / 25.4), "two columns"


# What must not break them


ODD: list[tuple[bool, dict[str, Any]]] = [
    (False, {"shape": (64, 16), "aspect": 0.02, "title": "$\\frac{ 100 % _x^ 漢字 😀 \x07\n\t"}),
    (True, {"shape": (16, 64), "aspect": 50.0, "upper_heating": 0.4, "converged": False, "title": "a long title " * 30}),
    (False, {"shape": (8, 8), "size": 1e-5, "extent": 6.0, "slip_share": 1.0}),
    (False, {"shape": (24, 24), "size": 1e4, "extent": 1.6, "slip_share": 0.0}),
]


@pytest.mark.parametrize(("normalised", "options"), [
    ODD[1],
    *(pytest.param(False, options, marks=pytest.mark.slow)
      for options in (ODD[0][1], *(options for _, options in ODD[2:]), {}, {"aspect": 2.5, "upper_heating": -0.8},
                      {"aspect": 4.5, "size": 0.15})),
])  # fmt: skip
def test_all_words_and_numbers_are_on_the_page(normalised: bool, options: dict[str, Any]) -> None:
    result = synthetic.result(**{"shape": (16, 16), **options})
    for kind in ("traction", "temperature", "centreline", "summary"):
        with plot_style.applied(), warnings.catch_warnings():
            warnings.filterwarnings("ignore", message="Glyph", category=UserWarning)
            picture = figure(result, kind, normalised=normalised)
            if picture is None:
                continue
            picture.draw_without_rendering()
            box = picture.get_tightbbox()
        width, height = picture.get_size_inches()
        assert min(box.x0, box.y0) >= -0.01 and box.x1 <= width + 0.01 and box.y1 <= height + 0.01, kind


def test_words_of_the_sheet_end_before_its_numbers() -> None:
    for scalar in SCALARS.values():
        words = scalar.meaning if len(scalar.meaning) <= 40 else scalar.brief
        assert words and len(f"{words} ({scalar.unit})") <= 46, scalar.name


def test_the_sheet_of_a_hot_contact_has_all_curves_in_a_row() -> None:
    picture = shown(solved(article_4_1(12)), "summary")
    curves = [axes for axes in picture.axes if axes.get_lines()]
    assert [axes.get_ylabel().split(" ")[0] for axes in curves] == ["pressure", "shear", "heat", "temperature"]
    assert len({axes.get_position().y0 for axes in curves}) == 1 and curves[-1].get_position().x1 > 0.97
    assert min(axes.get_position().y0 for axes in picture.axes if axes not in curves) > curves[0].get_position().y1


def test_pictures_of_a_run_have_one_unit() -> None:
    result = synthetic.result((12, 12), deformation=False)
    result = with_fields(result, heat_flux=result.coupled.fields["heat_flux"] * 2e5 / result.coupled.fields["heat_flux"].max())
    cut = 0.9 * result.y[np.flatnonzero(result.coupled.fields["heat_flux"].any(axis=0))[-1]]
    assert "heat flux q (W/mm²)" in [axes.get_ylabel() for axes in shown(result, "centreline", cut_y=cut).axes]


def test_columns_of_the_sheet_stand_apart() -> None:
    """The longest words beside powers of ten: the columns of the table do not touch, and end on the page. Each number stands
    beside its words, at any resolution: letters of other heights had moved them apart, by a row in thirty."""
    hot = {"creepage.longitudinal": 0.05, "rolling.speed_m_s": 100.0, "wear.lower.specific_wear_rate_mm3_Nm": 1e-6}
    picture = shown(solved(Case.parse(THERMAL).with_values(hot).problem), "summary")
    picture.draw_without_rendering()
    rows: dict[float, list[Any]] = {}
    for text in picture.texts:
        rows.setdefault(text.get_position()[1], []).append(text)
    written = {row[0].get_text(): [text.get_text() for text in row[1:]] for row in rows.values()}
    assert written["Hertz peak pressure (MPa)"] == ["898.62"] and written["maximum pressure (MPa)"][0] == "898.6"
    for row in rows.values():
        boxes = [text.get_window_extent() for text in row]
        assert all(left.x1 + 3.0 < right.x0 for left, right in pairwise(boxes)) and boxes[-1].x1 < picture.bbox.x1


def test_nan_fields_are_no_fields() -> None:
    result = with_fields(synthetic.result((16, 16), deformation=False), heat_flux=np.full((16, 16), np.nan))
    assert figure(result, "heat_flux") is None and figure(result, "temperature") is not None


@pytest.mark.slow
def test_pictures_do_not_depend_on_the_users_settings(tmp_path: pathlib.Path) -> None:
    """Neither a matplotlibrc with LaTeX and another size, nor a missing home, may change or break them; the package
    loads no pyplot ever."""
    (tmp_path / "matplotlibrc").write_text("text.usetex: True\nfont.size: 30\nfigure.facecolor: red\n")
    script = (
        "import sys, pathlib, warnings\n"
        "warnings.simplefilter('error')\n"
        "warnings.filterwarnings('ignore', category=DeprecationWarning, module='matplotlib|pyparsing')\n"
        "sys.path.insert(0, sys.argv[1])\n"
        "from thermoroll_cli.plots.pictures import draw\n"
        "from tests.support import synthetic\n"
        "draw(synthetic.result((16, 16), tangential=False), pathlib.Path(sys.argv[2]), dpi=40)\n"
        "assert 'matplotlib.pyplot' not in sys.modules\n"
    )
    here = str(pathlib.Path(__file__).parents[2])
    environment = {key: value for key, value in os.environ.items() if key not in ("HOME", "MPLBACKEND")}
    setting = {"MATPLOTLIBRC": str(tmp_path / "matplotlibrc"), "MPLBACKEND": "module://no_such_backend"}
    arguments = [sys.executable, "-c", script, here, str(tmp_path / "there")]
    done = subprocess.run(arguments, env={**environment, **setting}, capture_output=True, text=True, timeout=PATIENCE)
    assert done.returncode == 0, done.stderr
    (own,) = draw(synthetic.result((16, 16), tangential=False), tmp_path / "here", kinds=["summary"], dpi=40)
    assert (tmp_path / "there_summary.png").read_bytes() == own.read_bytes()


# What they show


def test_titles_have_the_maxima_of_the_table_with_their_unit() -> None:
    result = synthetic.result((16, 16))
    maxima = {"pressure": ("pressure_max_MPa", "MPa"), "traction": ("shear_max_MPa", "MPa"),
              "heat_flux": ("heat_flux_max_W_mm2", "W/mm²")}  # fmt: skip
    for kind, (scalar, unit) in maxima.items():
        expected = [f"{words}, max {state.scalars[scalar]:.4g} {unit}"
                    for words, state in ((WITHOUT, result.isothermal), (WITH, result.coupled))]
        assert titles(shown(result, kind)) == expected


def test_both_states_share_a_scale_that_begins_where_values_do() -> None:
    """Zero means something for a pressure; a temperature between 72 and 86 K is shown between these."""
    result = synthetic.result((24, 24), deformation=False)
    rise = result.coupled.fields["temperature_rise_lower"]
    lifted = 72.0 + 14.0 * rise / rise.max()
    warm = with_fields(result, temperature_rise_lower=lifted, temperature_rise_upper=lifted)
    (image,) = shown(warm, "temperature").axes[0].get_images()
    assert image.get_clim()[0] == pytest.approx(lifted.min())
    both = synthetic.result((24, 24))
    for axes in shown(both, "pressure").axes[:2]:
        assert axes.get_images()[0].get_clim() == pytest.approx((0.0, both.coupled.scalars["pressure_max_MPa"]))


def test_a_body_that_cools_has_diverging_colours_about_zero() -> None:
    picture = shown(synthetic.result((24, 24), upper_heating=-0.8, deformation=False), "temperature")
    for axes in picture.axes[:2]:
        low, high = axes.get_images()[0].get_clim()
        assert low == -high
    assert "min −" in titles(picture)[1]


@pytest.mark.parametrize(("fields", "from_zero", "expected"), [
    ([72.0, 86.0], False, (72.0, 86.0)), ([72.0, 86.0], True, (0.0, 86.0)), ([1.0, 86.0], False, (0.0, 86.0)),
    ([-1e-5, 86.0], False, (0.0, 86.0)), ([-20.0, 5.0], True, (-20.0, 5.0)), ([-86.0, -72.0], False, (-86.0, -72.0)),
])  # fmt: skip
def test_limits(fields: list[float], from_zero: bool, expected: tuple[float, float]) -> None:
    assert limits_of([np.array(fields)], from_zero) == expected


def test_wide_contacts_are_turned_and_long_ones_are_said_not_to_be_to_scale() -> None:
    for aspect, turned, note in ((1.0, False, False), (0.3, False, False), (3.0, True, False), (50.0, True, True),
                                 (0.02, False, True)):  # fmt: skip
        result = synthetic.result((24, 24), aspect=aspect, deformation=False)
        picture = shown(result, "pressure")
        along = picture.axes[0].get_ylabel() if turned else picture.axes[0].get_xlabel()
        assert along.startswith("x (") and ("material flow ↓" in picture.axes[0].get_xlabel()) == turned
        assert ("axes not to scale" in picture.get_suptitle()) == note and "from below" in picture.get_suptitle()
        assert picture.axes[0].get_box_aspect() <= 1.6


def test_stresses_have_their_unit_or_what_they_are_over() -> None:
    result = solve(Case.parse(MECHANICAL + "[subsurface]\nlayers = 6\n").with_values({"numerics.grid": 8}))
    plain, normalised = (figure(result, "subsurface_lower", normalised=flag) for flag in (False, True))
    assert plain is not None and normalised is not None
    assert plain.axes[1].get_xlabel() == r"von Mises stress $\sigma_\mathrm{vM}$ (MPa)"
    largest = float(result.bodies["lower"].below_stressed["von_mises"].max())
    assert float(plain.axes[1].lines[0].get_xdata().max()) == pytest.approx(1e-6 * largest)
    assert normalised.axes[1].get_xlabel() == r"von Mises stress $\sigma_\mathrm{vM}/p_0$"
    assert normalised.get_suptitle().endswith(f"p₀ = {result.of_problem['hertz_p0_MPa']:.4g} MPa")


def test_borders_differ_on_any_ground() -> None:
    """The core of a line is seen on light and dark maps alike, its casing on one of them."""
    lower, upper = (np.array(to_rgb(colours[0])) for colours in (CONTACT, STICK))
    assert np.abs(lower - upper).max() > 0.5 and min(lower.max(), upper.max()) > 0.9
    assert CONTACT[1] == STICK[1]


def test_borders_are_drawn_over_the_map_and_named() -> None:
    result = synthetic.result((48, 48), angle=0.3)
    picture = shown(result, "traction")
    lines = [[c for c in axes.collections if isinstance(c, LineCollection)] for axes in picture.axes[:2]]
    # Stick and contact, each on its casing; beside those of the other state.
    assert [len(found) for found in lines] == [4, 8]
    assert legend(picture) == ["contact border", "stick border", WITHOUT, "traction on the upper body"]
    assert "stick border" not in legend(shown(synthetic.result((48, 48), slip_share=1.0), "traction"))


def test_arrows_of_a_weak_patch_are_as_long_as_those_of_a_strong_one() -> None:
    result = synthetic.result((96, 32), deformation=False)
    x = np.arange(96)
    gap = ((x < 44) | (x > 52))[:, None]
    factor = np.where(x > 48, 0.05, 1.0)[:, None] * gap
    fields = {name: result.coupled.fields[name] * factor for name in ("pressure", "shear_x", "shear_y")}
    fields |= {name: result.coupled.fields[name] * gap for name in ("covered", "stick_share", "state")}
    picture = shown(with_fields(result, **fields), "traction")
    (arrows,) = (found for found in picture.axes[0].collections if hasattr(found, "U"))
    length, ahead = np.hypot(arrows.U, arrows.V), arrows.X > 0.0
    assert length[ahead].max() > 0.7 * length[~ahead].max()
    assert legend(picture)[-1] == "traction on the upper body, scaled in each patch"


def test_a_result_that_has_not_converged_is_marked() -> None:
    for title, some in (("A case", ["traction", "centreline", "summary"]), ("", ["pressure"])):
        result = synthetic.result((16, 16), converged=False, title=title)
        for kind in some:
            assert "NOT CONVERGED" in [text.get_text() for text in shown(result, kind).texts]


def test_the_cut_passes_the_maxima() -> None:
    """Along y = 0 where that passes them, through them elsewhere, or where it is asked for."""
    result = synthetic.result((48, 48), deformation=False)
    assert frame_of(result).cut_y == 0.0
    moved = {name: np.roll(values, 18, axis=1) for name, values in result.coupled.fields.items()}
    aside = with_fields(result, **moved)
    assert frame_of(aside).cut_y == pytest.approx(18 * (result.y[1] - result.y[0]), rel=0.05)
    picture = shown(aside, "centreline")
    peaks = {axes.get_ylabel(): max(line.get_ydata().max() for line in axes.get_lines()) for axes in picture.axes}
    assert peaks["pressure p (MPa)"] == pytest.approx(result.coupled.fields["pressure"].max() * 1e-6, rel=1e-6)
    assert "y = 0.05" in shown(aside, "centreline", cut_y=5e-5).get_suptitle()


def test_curves_have_the_local_friction_limit_in_words() -> None:
    picture = shown(synthetic.result((24, 24)), "centreline")
    assert legend(picture) == [WITHOUT, WITH, "friction limit μp"]
    result = synthetic.result((24, 24))
    yielding = dataclasses.replace(result, problem=dataclasses.replace(result.problem, interlayer=Interlayer(0.0, 1e8)))
    assert legend(shown(yielding, "centreline"))[-1] == "limit of friction and of the interlayer"


def test_any_field_can_be_drawn() -> None:
    result = synthetic.result((24, 24))
    assert shown(result, "gap").axes[-1].get_ylabel().startswith("distance between the deformed surfaces")
    assert "slip velocity" in shown(result, "slip").axes[-1].get_ylabel()
    assert figure(result, "friction_coefficient") is None


def test_the_summary_has_digits_as_the_errors_have() -> None:
    result = synthetic.result((24, 24))
    problem = dataclasses.replace(result.problem, normal_force=80e3)
    picture = shown(dataclasses.replace(result, problem=problem), "summary")
    texts = [line for text in picture.texts for line in text.get_text().split("\n")]
    assert "W = 80 kN, μ = 0.3, V = 200 m/s, grid 24 × 24" in texts
    value, _, error = scalar_text("pressure_max_MPa", row_of(result.summary())).partition(" ")
    assert value in texts and error in texts and error.startswith("± ")
    assert "spin (rad/mm)" not in texts, "rows of zeros are left out"
    assert not any("-" in text for text in texts if text[:1].isdigit() or text[:1] in "−-")
    bars = [axes.get_ylim() for axes in shown(result, "heat_flux").axes[2:]]
    assert bars[0][1] in [axes.get_ylim()[1] for axes in picture.axes], "alike in both"


@pytest.mark.parametrize(("text", "expected"), [
    ("-1234.6 ± 0.2", "−1234.6 ± 0.2"), ("4.171e-05", "4.171 × 10⁻⁵"), ("1e+12", "1 × 10¹²"),
    ("(2.50 ± 0.12)e9", "(2.50 ± 0.12) × 10⁹"), ("–", "–"),
])  # fmt: skip
def test_numbers_look_as_in_print(text: str, expected: str) -> None:
    assert readable(text) == expected


@pytest.mark.parametrize(("unit", "maximum", "expected"), [
    ("m", 2e-4, "mm"), ("m", 5e-5, "µm"), ("m", 5e-7, "nm"), ("m", 50.0, "m"), ("Pa", 1.4e9, "MPa"), ("Pa", 3e2, "Pa"),
    ("Pa", 3e10, "GPa"), ("W/m2", 4e8, "W/mm²"), ("K", 300.0, "K"), ("K", 1e-3, "mK"), ("K", 0.0, "K"), ("N", 80e3, "kN"),
    ("1", 0.3, ""),
])  # fmt: skip
def test_units_keep_numbers_readable(unit: str, maximum: float, expected: str) -> None:
    assert unit_for(unit, maximum)[1] == expected


def test_every_quantity_of_the_pictures_has_a_picture_of_its_own() -> None:
    assert set(QUANTITIES) <= set(KINDS)


# Borders


@pytest.mark.parametrize("elements", [16, 32, 64, 128])
def test_borders_run_between_the_elements(elements: int) -> None:
    result = synthetic.result((elements, elements))
    state, radius = result.isothermal, result.of_problem["hertz_a_mm"] * 1e-3
    spacing = state.x[1] - state.x[0]
    borders = borders_of(state.x, state.y, state.fields)
    assert len(borders.contact) == len(borders.stick) == 1
    distance = np.abs(np.hypot(*borders.contact[0].T) - radius)
    assert distance.max() < 0.25 * spacing
    # Carter's stick strips have their middle half the slip length towards the leading edge.
    slip = 0.4 * 2 * radius
    line = borders.stick[0][np.hypot(*borders.stick[0].T) < 0.8 * radius]
    expected = np.sqrt(radius**2 - line[:, 1] ** 2) - slip
    assert np.abs(line[:, 0] - expected).max() < 0.3 * spacing
    assert np.abs(np.hypot(*borders.stick[0][[0, -1]].T) - radius).min() > -1.0 and line.size


def test_borders_of_contacts_without_slip_or_stick() -> None:
    for share in (0.0, 1.0):
        state = synthetic.result((32, 32), slip_share=share).isothermal
        borders = borders_of(state.x, state.y, state.fields)
        assert len(borders.contact) == 1 and borders.stick == []


def test_a_stick_border_nearly_along_x_has_no_steps() -> None:
    """Shares know the border along x only: from row to row it advances by four elements here."""
    x, y = np.arange(64.0), np.arange(12.0)
    border = 10.3 + 4.0 * y
    covered, sticking = np.ones((64, 12)), np.clip(border[None, :] - x[:, None] + 0.5, 0.0, 1.0)
    fields = {"state": covered, "covered": covered, "stick_share": sticking}
    (line,) = borders_of(x, y, fields).stick
    inner = line[(line[:, 1] > 1.0) & (line[:, 1] < 10.0)]
    assert len(inner) > 20 and np.abs(inner[:, 1] - (inner[:, 0] - 10.3) / 4.0).max() < 0.05


def test_the_border_of_whole_elements_has_no_steps() -> None:
    """Elements of a disc are covered entirely or not at all: four of them stand out at each of its ends."""
    x, radius = np.arange(64.0) - 31.5, 26.55
    disc = np.hypot(x[:, None], x) < radius
    (line,) = borders_of(x, x, {"covered": disc, "stick_share": disc}).contact
    assert np.abs(np.hypot(*line.T) - radius).max() < 0.3
    turned = np.unwrap(np.arctan2(*np.diff(line, axis=0).T))
    turned *= np.sign(turned[-1] - turned[0])
    assert (np.maximum.accumulate(turned) - turned).max() < 0.05


def test_a_lone_stick_element_has_no_border() -> None:
    state = synthetic.result((32, 32), slip_share=1.0).isothermal
    stick = np.zeros((32, 32))
    stick[14, 17] = 1.0
    assert borders_of(state.x, state.y, {**state.fields, "stick_share": stick}).stick == []


def test_a_stick_border_outside_the_contact_is_not_named() -> None:
    x = np.linspace(-1.0, 1.0, 33)
    radius = np.hypot(x[:, None], x)
    covered = np.clip(16.0 * (0.9 - radius) + 0.5, 0.0, 1.0)
    slips = (covered < 0.45) & (x[:, None] > 0.0)  # a rim that slips, of which less than half is in the contact
    assert borders_of(x, x, {"covered": covered, "stick_share": np.where(slips, 0.0, covered)}).stick == []
    slips = (covered > 0.0) & (x[:, None] > 0.5)
    assert len(borders_of(x, x, {"covered": covered, "stick_share": np.where(slips, 0.0, covered)}).stick) == 1


def test_stick_borders_reach_the_border_of_the_contact() -> None:
    state = synthetic.result((48, 48)).isothermal
    borders = borders_of(state.x, state.y, state.fields)
    (line,) = borders.stick
    assert borders.outline is not None
    assert not borders.outline.contains_points(line[[0, -1]]).any(), "cut off there when drawn"


def test_a_contact_at_the_rim_of_the_domain_is_closed_beyond_it() -> None:
    state = synthetic.result((32, 32), extent=1.6).isothermal
    (line,) = borders_of(state.x, state.y, state.fields).contact
    np.testing.assert_array_equal(line[0], line[-1])


# Temperatures across the track


def test_the_track_shows_both_bodies_where_one_returns() -> None:
    result = solved(wheel_on_rail(16, bulk_lower=20.0, bulk_upper=20.0))
    axes = shown(result, "track").axes[0]
    lines = {str(line.get_label()): np.asarray(line.get_ydata(), dtype=float) for line in axes.lines}
    assert set(lines) == {"lower: hottest along rolling", "upper: hottest along rolling", "upper: as it enters",
                          "upper: mean of the surface"}  # fmt: skip
    s = result.coupled.scalars
    assert abs(lines["upper: hottest along rolling"].max() - s["surface_temperature_max_upper_K"]) < 2.0
    assert abs(lines["upper: as it enters"].max() - s["entry_temperature_max_upper_K"]) < 1.0
    assert lines["lower: hottest along rolling"].min() >= 20.0


def test_without_a_track_there_is_no_picture_of_it() -> None:
    assert figure(solved(wheel_on_rail(16, upper_track=None)), "track") is None


def test_a_map_or_a_curve_is_drawn_on_axes_of_the_caller() -> None:
    result = synthetic.result((24, 24))
    canvas = Figure()
    left, right = canvas.subplots(1, 2)
    assert result.plot("temperature", ax=left) is canvas and result.plot(ax=right) is canvas
    assert len(left.images) == len(right.images) == 1 and len(canvas.axes) == 4
    assert canvas.axes[3].get_ylabel() == "pressure p (MPa)"
    drawn = float(np.asarray(right.images[0].get_array()).max())
    assert drawn == pytest.approx(1e-6 * float(result.coupled.fields["pressure"].max()))
    with pytest.raises(ValueError, match="there is no picture 'presure'"):
        result.plot("presure", ax=left)
    with pytest.raises(ValueError, match="'summary' has several diagrams: on axes of yours go pressure"):
        result.plot("summary", ax=left)
