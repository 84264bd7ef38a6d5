"""Pictures of runs and sweeps: which there are, how they look, what they cost, and what must not break them."""

from __future__ import annotations

import dataclasses
import itertools
import os
import pathlib
import shutil
import subprocess
import sys
import typing
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure
from matplotlib.testing.compare import compare_images
from pydantic import BaseModel

from tests.support import synthetic
from tests.support.command_line import PATIENCE
from tests.support.cost import cost_ratio
from thermoroll_cli.files.case_model import Settings
from thermoroll_cli.files.result.hdf5 import read_result, write_result
from thermoroll_cli.plots import run_figures, sheet, sweep_figures
from thermoroll_cli.plots.borders import borders_of
from thermoroll_cli.plots.field_figures import grid_for
from thermoroll_cli.plots.run_figures import write_figures
from thermoroll_cli.plots.sweep_columns import with_value, words_of
from thermoroll_cli.plots.sweep_figures import is_logarithmic, write_sweep_figure
from thermoroll_cli.plots.units import unit_for
from thermoroll_cli.plots.view import view_of
from thermoroll_cli.problem.result import Result

BASELINES = pathlib.Path(__file__).parent / "baseline_images"
TOLERANCE = 6.0
"""Root mean square of the grey levels; another version of matplotlib's fonts gives about 2, a missing line 7 and more."""

ALL = ["pressure", "traction", "heat_flux", "temperature", "centreline", "summary"]


def kinds(paths: list[pathlib.Path], stem: str) -> list[str]:
    return [path.stem.removeprefix(stem + "_") for path in paths]


# Which pictures there are


@pytest.fixture
def coarse(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Pictures of few pixels, where only their number or their being drawn at all matters."""
    monkeypatch.setattr(sheet, "DPI", 40)
    yield


@pytest.mark.parametrize(
    ("options", "missing"),
    [
        ({}, set()),
        ({"heat": False}, {"heat_flux", "temperature"}),
        ({"tangential": False}, {"heat_flux", "temperature", "traction"}),
        ({"upper_heating": 0.5, "deformation": False}, set()),
    ],
)
def test_what_was_not_computed_has_no_picture(
    tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch, options: dict[str, Any], missing: set[str]
) -> None:
    def save(figure: Figure, path: pathlib.Path) -> pathlib.Path:
        path.touch()  # others look at what is in it
        return path

    monkeypatch.setattr(run_figures, "save", save)
    written = write_figures(synthetic.result((24, 24), **options), tmp_path / "case")
    assert kinds(written, "case") == [name for name in ALL if name not in missing]
    assert sorted(os.listdir(tmp_path)) == sorted(path.name for path in written)


@pytest.mark.usefixtures("coarse")
def test_a_stored_result_gives_the_same_pictures(tmp_path: pathlib.Path) -> None:
    result = synthetic.result((24, 20), aspect=1.5)
    write_result(tmp_path / "r.h5", result, case_text="", case_json="{}", command_line="")
    direct = write_figures(result, tmp_path / "direct")
    stored = write_figures(read_result(tmp_path / "r.h5"), tmp_path / "stored")
    assert [path.read_bytes() for path in direct] == [path.read_bytes() for path in stored]


@pytest.mark.parametrize("image_format", ["png", "svg", "pdf"])
@pytest.mark.usefixtures("coarse")
def test_every_format_is_reproducible(tmp_path: pathlib.Path, image_format: str) -> None:
    magic = {"png": b"\x89PNG", "svg": b"<?xml", "pdf": b"%PDF"}[image_format]
    result = synthetic.result((16, 16), tangential=image_format == "svg", deformation=False)
    one = write_figures(result, tmp_path / "a", image_format=image_format)
    two = write_figures(result, tmp_path / "b", image_format=image_format)
    for first, second in zip(one, two, strict=True):
        content = first.read_bytes()
        assert content.startswith(magic) and first.suffix == "." + image_format
        assert content == second.read_bytes()


def test_an_unknown_format_writes_nothing(tmp_path: pathlib.Path) -> None:
    with pytest.raises(ValueError, match="png, svg, pdf"):
        write_figures(synthetic.result((8, 8)), tmp_path / "a", image_format="gif")
    assert os.listdir(tmp_path) == []


@pytest.mark.usefixtures("coarse")
def test_a_picture_that_cannot_be_written_says_so(tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(OSError, match=r"cannot write .*a_pressure\.png: No such file or directory"):
        write_figures(synthetic.result((8, 8)), tmp_path / "absent" / "a")

    def interrupt(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(sheet.os, "replace", interrupt)
    with pytest.raises(KeyboardInterrupt):
        write_figures(synthetic.result((8, 8)), tmp_path / "a")
    assert os.listdir(tmp_path) == []


# What must not break them


@pytest.mark.parametrize(
    ("normalised", "options"),
    [
        (False, {"shape": (64, 16), "aspect": 0.02, "title": "$\\frac{ 100 % _x^ 漢字 😀 \x07\n\t"}),
        (True, {"shape": (16, 64), "aspect": 50.0, "upper_heating": 0.4, "converged": False, "title": "a long title " * 30}),
        (False, {"shape": (8, 8), "size": 1e-5, "extent": 6.0, "slip_share": 1.0}),
        (False, {"shape": (24, 24), "size": 1e4, "extent": 1.6, "slip_share": 0.0}),
    ],
)
@pytest.mark.usefixtures("coarse")
def test_odd_results_are_drawn(tmp_path: pathlib.Path, normalised: bool, options: dict[str, Any]) -> None:
    assert write_figures(synthetic.result(**options), tmp_path / "odd", normalised=normalised)


@pytest.mark.usefixtures("coarse")
def test_nan_fields_are_no_fields(tmp_path: pathlib.Path) -> None:
    result = synthetic.result((16, 16), deformation=False)
    fields = {**result.coupled.fields, "heat_flux": np.full((16, 16), np.nan)}
    state = dataclasses.replace(result.coupled, fields=fields)
    written = write_figures(dataclasses.replace(result, coupled=state, isothermal=state), tmp_path / "a")
    assert "heat_flux" not in kinds(written, "a") and "temperature" in kinds(written, "a")


def test_pictures_do_not_depend_on_the_users_settings(tmp_path: pathlib.Path) -> None:
    """Neither a matplotlibrc with LaTeX and another size, nor a missing home, may change or break them; the package
    itself loads no matplotlib and no pyplot ever."""
    (tmp_path / "matplotlibrc").write_text("text.usetex: True\nfont.size: 30\nfigure.facecolor: red\n")
    script = (
        "import sys, pathlib, warnings\n"
        "warnings.simplefilter('error')\n"
        "sys.path.insert(0, sys.argv[1])\n"
        "from thermoroll_cli.plots import sheet\n"
        "from thermoroll_cli.plots.run_figures import write_figures\n"
        "assert 'matplotlib' not in sys.modules\n"
        "from tests.support import synthetic\n"
        "sheet.DPI = 40\n"
        "write_figures(synthetic.result((16, 16), tangential=False), pathlib.Path(sys.argv[2]))\n"
        "assert 'matplotlib.pyplot' not in sys.modules\n"
    )
    here = str(pathlib.Path(__file__).parents[2])
    environment = {key: value for key, value in os.environ.items() if key not in ("HOME", "MPLBACKEND")}
    settings = [{}, {"MATPLOTLIBRC": str(tmp_path / "matplotlibrc"), "MPLBACKEND": "module://no_such_backend"}]
    contents = []
    for number, setting in enumerate(settings):
        stem = tmp_path / str(number)
        arguments = [sys.executable, "-c", script, here, str(stem)]
        done = subprocess.run(arguments, env={**environment, **setting}, capture_output=True, text=True, timeout=PATIENCE)
        assert done.returncode == 0, done.stderr
        contents.append(stem.with_name(f"{number}_summary.png").read_bytes())
    assert contents[0] == contents[1]


# How they look


def check(actual: pathlib.Path, name: str) -> None:
    """Compare with the baseline; with THERMOROLL_WRITE_BASELINES=1 make it the baseline instead."""
    expected = BASELINES / f"{name}.png"
    if os.environ.get("THERMOROLL_WRITE_BASELINES"):
        BASELINES.mkdir(exist_ok=True)
        shutil.copy(actual, expected)
    assert compare_images(str(expected), str(actual), tol=TOLERANCE) is None


LOOKS: dict[str, tuple[dict[str, Any], set[str]]] = {
    "round": ({"shape": (48, 48), "angle": 0.3}, set(ALL)),
    "flat": ({"shape": (64, 24), "aspect": 0.3, "upper_heating": 0.6}, {"temperature", "summary"}),
    "tall": ({"shape": (24, 64), "aspect": 5.0, "deformation": False}, {"traction", "summary"}),
    "unfinished": ({"shape": (20, 20), "heat": False, "converged": False}, {"traction"}),
    "normalised": ({"shape": (48, 32), "aspect": 2.0}, {"traction", "centreline"}),
    "line": ({"shape": (64, 32), "aspect": 1.0 / 41.0}, {"summary", "traction"}),
    "cooled": ({"shape": (24, 24), "upper_heating": -0.8, "deformation": False}, {"summary", "temperature", "centreline"}),
}


def some_figures(
    result: Result, stem: pathlib.Path, wanted: set[str], monkeypatch: pytest.MonkeyPatch, *, normalised: bool = False
) -> list[pathlib.Path]:
    """Small pictures of the wanted kinds only: rendering is what takes the time."""

    def save(figure: Any, path: pathlib.Path) -> pathlib.Path:
        return sheet.save(figure, path) if path.stem.removeprefix(stem.name + "_") in wanted else path

    monkeypatch.setattr(sheet, "DPI", 50)
    monkeypatch.setattr(run_figures, "save", save)
    paths = write_figures(result, stem, normalised=normalised)
    return [path for path in paths if path.exists()]


@pytest.mark.parametrize("look", LOOKS)
def test_pictures_look_as_they_did(tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch, look: str) -> None:
    options, wanted = LOOKS[look]
    result = synthetic.result(**options)
    paths = some_figures(result, tmp_path / look, wanted, monkeypatch, normalised=look == "normalised")
    assert len(paths) == len(wanted)
    for path in paths:
        check(path, path.stem)


def test_the_comparison_notices_another_border(tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch) -> None:
    result = synthetic.result((48, 48), angle=0.3, slip_share=0.6)
    (path,) = some_figures(result, tmp_path / "other", {"traction"}, monkeypatch)
    assert compare_images(str(BASELINES / "round_traction.png"), str(path), tol=TOLERANCE) is not None


def test_the_resolution_for_print(tmp_path: pathlib.Path) -> None:
    from PIL import Image

    with Image.open(write_figures(synthetic.result((16, 16), tangential=False), tmp_path / "a")[0]) as image:
        assert image.info["dpi"] == pytest.approx((200, 200), abs=0.1)
        assert image.width > 700


@pytest.mark.parametrize("side", ["left", "right"])
def test_letters_drawn_as_a_shape_stand_where_text_does(side: str) -> None:
    from thermoroll_cli.plots.lettering import Column

    lines, boxes = "Hertz peak pressure (MPa)\n\nγ_st ± 0.5 µm²", []
    with sheet.style():
        for shape in (True, False):
            figure = sheet.new_figure(3.0, 1.0)
            column = Column(0.5, 0.9, lines, size=7.5, pitch=0.2, ha=side, transform=figure.transFigure)
            if shape:
                figure.add_artist(column)
            else:
                figure.text(0.5, 0.9, lines, fontsize=7.5, va="top", ha=side, linespacing=0.2 * 72.0 / 7.5)
            figure.canvas.draw()
            ink = np.argwhere(np.asarray(figure.canvas.buffer_rgba())[:, :, 0] < 128)  # type: ignore[attr-defined]
            boxes.append([*ink.min(axis=0), *ink.max(axis=0)])
    assert boxes[0] == pytest.approx(boxes[1], abs=5.0)  # pixels, of 200 to an inch


# Borders, layout, units


@pytest.mark.parametrize("elements", [16, 32, 64, 128])
def test_borders_run_between_the_elements(elements: int) -> None:
    view = view_of(synthetic.result((elements, elements)))
    spacing, radius = view.x[1] - view.x[0], view.semi_axes[0]
    borders = borders_of(view.x, view.y, view.states[0])
    assert len(borders.contact) == len(borders.stick) == 1
    distance = np.abs(np.hypot(*borders.contact[0].T) - radius)
    assert distance.max() < 0.2 * spacing
    # Carter's stick strips have their middle half the slip length towards the leading edge.
    slip = 0.4 * 2 * radius
    line = borders.stick[0][np.hypot(*borders.stick[0].T) < 0.9 * radius]
    expected = np.sqrt(radius**2 - line[:, 1] ** 2) - slip
    assert np.abs(line[:, 0] - expected).max() < 0.3 * spacing


def test_borders_of_contacts_without_slip_or_stick() -> None:
    for share in (0.0, 1.0):
        view = view_of(synthetic.result((32, 32), slip_share=share))
        borders = borders_of(view.x, view.y, view.states[0])
        assert len(borders.contact) == 1 and borders.stick == []


def test_a_contact_at_the_rim_of_the_domain_is_closed_beyond_it() -> None:
    view = view_of(synthetic.result((32, 32), extent=1.6))
    (line,) = borders_of(view.x, view.y, view.states[0]).contact
    np.testing.assert_array_equal(line[0], line[-1])
    assert np.abs(line[:, 0]).max() > np.abs(view.x).max()


def test_panels_are_arranged_by_shape() -> None:
    def arrangement(count: int, states: int, aspect: float) -> tuple[int, int]:
        grid = grid_for(count, states, aspect)
        return grid.rows, grid.columns

    assert arrangement(2, 2, 1.0) == (1, 2)
    assert arrangement(2, 2, 0.2) == (2, 1)
    assert arrangement(4, 2, 3.0) == (2, 2)
    assert arrangement(2, 1, 1.0) == (1, 2)
    assert arrangement(1, 1, 1.0) == (1, 1)
    assert grid_for(2, 2, 5.0).true_shape and not grid_for(2, 2, 20.0).true_shape


@pytest.mark.parametrize(
    ("unit", "maximum", "expected"),
    [
        ("m", 2e-4, "mm"),
        ("m", 6e-3, "mm"),
        ("m", 5e-7, "nm"),
        ("m", 50.0, "m"),
        ("Pa", 1.4e9, "MPa"),
        ("Pa", 3e2, "Pa"),
        ("Pa", 3e10, "GPa"),
        ("W/m2", 4e8, "W/mm²"),
        ("K", 300.0, "K"),
        ("K", 1e-3, "mK"),
        ("K", 0.0, "K"),
    ],
)
def test_units_keep_numbers_readable(unit: str, maximum: float, expected: str) -> None:
    scale = unit_for(unit, maximum)
    assert scale.unit == expected


# What they cost


def test_pictures_are_cheap(tmp_path: pathlib.Path) -> None:
    """Each costs on average as much as a few bare maps of one field (measured: 1.6)."""
    result = synthetic.result((128, 128))
    written: list[pathlib.Path] = []

    def bare_map() -> None:
        figure = Figure(figsize=(7.0, 5.0), dpi=150)
        axes = figure.add_subplot()
        figure.colorbar(axes.pcolormesh(result.x, result.y, result.coupled.fields["pressure"].T))
        figure.savefig(tmp_path / "bare.png")

    ratio = cost_ratio(lambda: written.extend(write_figures(result, tmp_path / "a")), bare_map, rounds=2)
    assert ratio / len(set(written)) < 3.5


# Sweeps


def table(**columns: Any) -> dict[str, list[Any]]:
    speeds = [10.0, 20.0, 50.0, 100.0]
    radii = [15.0, 30.0]
    rows = [(radius, speed) for radius in radii for speed in speeds]
    made: dict[str, list[Any]] = {
        "rolling.speed_m_s": [speed for _, speed in rows],
        "geometry.lower_radius_y_mm": [radius for radius, _ in rows],
        "status": ["converged"] * len(rows),
        "Q_F_W": [0.01 * speed * radius**0.2 for radius, speed in rows],
        "isothermal.Q_F_W": [0.011 * speed * radius**0.2 for radius, speed in rows],
        "gamma_c": [1.0 - speed / 1000.0 for _, speed in rows],
        "isothermal.gamma_c": [1.0] * len(rows),
        "temperature_rise_max_lower_K": [speed / radius for radius, speed in rows],
        "force_x_N": [15.0] * len(rows),
        # Rounding noise gets no diagram.
        "force_y_N": [1e-16] * len(rows),
        "spin_moment_Nmm": [1e-15] * len(rows),
        "hertz_a_mm": [0.2] * len(rows),
        "hertz_b_mm": [0.2] * len(rows),
    }
    return {**made, **columns}


def test_sweeps_look_as_they_did(tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sheet, "DPI", 50)
    over = ["rolling.speed_m_s", "geometry.lower_radius_y_mm"]
    check(write_sweep_figure(table(), over, tmp_path / "sweep.png", title="A sweep_of $two"), "sweep")


def drawn(monkeypatch: pytest.MonkeyPatch, tmp_path: pathlib.Path, columns: dict[str, list[Any]], over: list[str]) -> Any:
    """The figure of a sweep, as it is saved."""
    figures = []
    monkeypatch.setattr(sweep_figures, "save", lambda figure, path: figures.append(figure))
    write_sweep_figure(columns, over, tmp_path / "a.png")
    return figures[0]


OVER = ["rolling.speed_m_s", "geometry.lower_radius_y_mm"]


def test_every_line_of_a_sweep_has_a_colour_of_its_own(monkeypatch: pytest.MonkeyPatch, tmp_path: pathlib.Path) -> None:
    radii = [float(k) for k in range(1, 31)]
    rows = [(radius, speed) for radius in radii for speed in (10.0, 20.0, 50.0)]
    columns = {OVER[0]: [v for _, v in rows], OVER[1]: [r for r, _ in rows], "Q_F_W": [r * v for r, v in rows]}
    figure = drawn(monkeypatch, tmp_path, columns, OVER)
    assert len({line.get_color() for line in figure.axes[0].get_lines()}) == 30
    assert len(figure.legends[0].get_texts()) == 15


def test_failed_points_are_marked_where_they_were_asked_for(monkeypatch: pytest.MonkeyPatch, tmp_path: pathlib.Path) -> None:
    columns = table()
    columns["status"][3] = columns["status"][7] = "not_converged"
    axes = drawn(monkeypatch, tmp_path, columns, OVER).axes[0]
    marks = [line for line in axes.get_lines() if line.get_marker() == "x"]
    curves = [line for line in axes.get_lines() if line not in marks]
    assert [list(line.get_xdata()) for line in marks] == [[100.0], [100.0]]
    assert [mark.get_color() for mark in marks] == list(dict.fromkeys(curve.get_color() for curve in curves))
    assert marks[0].get_ydata()[0] < marks[1].get_ydata()[0], "one cross covers the other"
    assert max(x for line in curves for x in line.get_xdata()) == 50.0


def test_peaks_without_a_limit_are_marked(monkeypatch: pytest.MonkeyPatch, tmp_path: pathlib.Path) -> None:
    columns = table(pressure_max_MPa=[100.0 * row for row in range(1, 9)])
    columns["unbounded"] = ["", "pressure_max_MPa shear_max_MPa", *[""] * 6]
    figure = drawn(monkeypatch, tmp_path, columns, OVER)
    rings = {axes.get_ylabel(): [list(line.get_ydata()) for line in axes.get_lines() if line.get_markerfacecolor() == "white"]
             for axes in figure.axes}
    assert rings.pop("max. pressure (MPa)") == [[200.0]] and not any(rings.values())
    assert "no limit: a free end" in [text.get_text() for text in figure.legends[0].get_texts()]


def test_every_key_with_a_unit_can_be_swept_under_its_unit() -> None:
    def keys(model: type[BaseModel]) -> Iterator[tuple[str, str]]:
        for name, field in model.model_fields.items():
            for part in (field.annotation, *typing.get_args(field.annotation)):
                if isinstance(part, type) and issubclass(part, BaseModel):
                    yield from keys(part)
            extra = field.json_schema_extra
            yield name, str(extra.get("unit", "1")) if isinstance(extra, dict) else "1"

    units = {name: unit for name, unit in keys(Settings) if unit != "1"}
    assert len(units) > 20
    assert [name for name in units if not words_of(f"table.{name}").endswith(")")] == []
    assert with_value("load.normal_N", 150e3) == "normal load = 150000 N"
    assert with_value("load.friction_coefficient", 0.25) == "friction coefficient = 0.25"


def test_an_axis_does_not_zoom_into_the_error_of_its_numbers(monkeypatch: pytest.MonkeyPatch, tmp_path: pathlib.Path) -> None:
    wobbling = [0.5 + 1e-3 * (-1) ** row for row in range(8)]
    columns = table(gamma_st=wobbling, **{"error.gamma_st": [0.01] * 8})
    figure = drawn(monkeypatch, tmp_path, columns, OVER)
    (axes,) = (axes for axes in figure.axes if "gamma_{st}" in axes.get_ylabel())
    low, high = axes.get_ylim()
    assert high - low >= 6.0 * 0.01 * 0.5


def test_a_mechanical_sweep_shows_what_changes(monkeypatch: pytest.MonkeyPatch, tmp_path: pathlib.Path) -> None:
    """Ratios that only heat can change, and a state without heat equal to the one with it, are not drawn."""
    columns = table(gamma_c=[1.0] * 8, gamma_p=[1.0] * 8)
    columns["isothermal.Q_F_W"] = list(columns["Q_F_W"])
    figure = drawn(monkeypatch, tmp_path, columns, OVER)
    assert not any("gamma" in axes.get_ylabel() for axes in figure.axes)
    assert "isothermal" not in [text.get_text() for text in figure.legends[0].get_texts()]


def test_forces_are_told_over_the_friction_limit(monkeypatch: pytest.MonkeyPatch, tmp_path: pathlib.Path) -> None:
    columns = table(force_x_N=[float(row) for row in range(8)], friction_limit_N=[20.0] * 8)
    figure = drawn(monkeypatch, tmp_path, columns, OVER)
    (axes,) = (axes for axes in figure.axes if "F_x" in axes.get_ylabel())
    figure.canvas.draw()
    (right,) = axes.child_axes
    assert right.get_ylim() == pytest.approx([limit / 20.0 for limit in axes.get_ylim()])
    varying = drawn(monkeypatch, tmp_path, columns | {"friction_limit_N": [20.0 + row for row in range(8)]}, OVER)
    assert not any(axes.child_axes for axes in varying.axes)


def test_titles_tell_the_maxima_of_the_table(monkeypatch: pytest.MonkeyPatch, tmp_path: pathlib.Path) -> None:
    result = synthetic.result((16, 16))
    figures = {}
    monkeypatch.setattr(run_figures, "save", lambda figure, path: figures.setdefault(path.stem.split("_", 1)[1], figure))
    write_figures(result, tmp_path / "a")
    maxima = {"pressure": "pressure_max_MPa", "traction": "shear_max_MPa", "heat_flux": "heat_flux_max_W_mm2"}
    for picture, scalar in maxima.items():
        titles = [axes.get_title() for axes in figures[picture].axes[:2]]
        states = result.isothermal, result.coupled
        assert titles == [f"{name}, max {state.scalars[scalar]:.4g}" for name, state in zip(("isothermal", "coupled"), states,
                                                                                         strict=True)]


@pytest.mark.parametrize("top", [40.0, 300.0, 5000.0, 1e6])
def test_numbers_on_a_logarithmic_axis_keep_apart(monkeypatch: pytest.MonkeyPatch, tmp_path: pathlib.Path, top: float) -> None:
    columns = {OVER[0]: list(np.geomspace(2.0, top, 5)), "Q_F_W": [1.0, 2.0, 3.0, 4.0, 5.0]}
    figure = drawn(monkeypatch, tmp_path, columns, OVER[:1])
    figure.canvas.draw()
    axes = figure.axes[0]
    left, right = axes.get_xlim()
    boxes = [label.get_window_extent() for label, place in zip(axes.get_xticklabels(), axes.get_xticks(), strict=True)
             if left <= place <= right and label.get_text()]
    assert len(boxes) >= 2
    assert all(a.x1 < b.x0 for a, b in itertools.pairwise(boxes))


@pytest.mark.usefixtures("coarse")
def test_failed_points_are_left_out(tmp_path: pathlib.Path) -> None:
    columns = table()
    columns["Q_F_W"][1:4] = [None, "", "nan"]
    columns["gamma_c"] = [None] * 8
    columns["isothermal.gamma_c"] = [float("nan")] * 8
    assert write_sweep_figure(columns, ["rolling.speed_m_s"], tmp_path / "a.svg").exists()
    only_failures = {"rolling.speed_m_s": [1.0, 2.0], "Q_F_W": [None, None]}
    assert write_sweep_figure(only_failures, ["rolling.speed_m_s"], tmp_path / "b.png").exists()
    one_point = {"rolling.speed_m_s": ["1.0"], "Q_F_W": ["2.5"]}
    assert write_sweep_figure(one_point, ["rolling.speed_m_s"], tmp_path / "c.png").exists()


def test_a_sweep_over_nothing_is_refused(tmp_path: pathlib.Path) -> None:
    for over in ([], ["load.normal_N"], ["status"]):
        with pytest.raises(ValueError):
            write_sweep_figure(table(), over, tmp_path / "a.png")
    assert os.listdir(tmp_path) == []


def test_axes_are_logarithmic_where_the_points_are() -> None:
    assert is_logarithmic(np.geomspace(1e-5, 1e-2, 7))
    assert not is_logarithmic(np.linspace(1.0, 100.0, 7))
    assert not is_logarithmic(np.array([1.0, 100.0]))
    assert not is_logarithmic(np.array([-1.0, 0.0, 10.0]))


def test_case_keys_become_words() -> None:
    assert words_of("rolling.speed_m_s") == "rolling speed (m/s)"
    assert words_of("creepage.longitudinal") == "longitudinal creepage"
    assert words_of("creepage.spin_rad_mm") == "spin (rad/mm)"
    assert words_of("material.lower.diffusivity_mm2_s") == "diffusivity (mm²/s)"
    assert words_of("load.normal_N") == "normal load (N)"
    assert words_of("load.friction_coefficient") == "friction coefficient"
    assert words_of("force.lateral_N") == "lateral force (N)"
