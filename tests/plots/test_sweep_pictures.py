"""Pictures of sweeps: diagrams, curves, bands, maps, marks of failed points, comparison with simplified theories."""

from __future__ import annotations

import itertools
import math
import pathlib
from typing import Any

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from PIL import Image

from tests.support.command_line import THERMAL, call
from tests.support.sampling import sampled
from thermoroll_cli.exact.kalker import creepage_coefficients, linear_creep_forces
from thermoroll_cli.files.case_schema import case_schema
from thermoroll_cli.files.case_table import UNIT_AT_END
from thermoroll_cli.files.table_file import read_table, write_csv
from thermoroll_cli.plots import style as plot_style
from thermoroll_cli.plots.run_frame import WITHOUT
from thermoroll_cli.plots.sweep_figures import is_logarithmic, sweep_figure, with_value, words_of
from thermoroll_cli.plots.wheelset_figures import wheelset_sweep_figure
from thermoroll_cli.problem.columns import Columns
from thermoroll_cli.problem.names import ALL_SCALARS, DIAGRAMS, unit_of
from thermoroll_cli.studies.sweeps import table_picture
from thermoroll_cli.studies.sweeps.table_picture import draw_table

OVER = ["rolling.speed_m_s", "geometry.lower_radius_y_mm"]


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


def drawn(columns: dict[str, list[Any]], over: list[str], **options: Any) -> Figure:
    with plot_style.applied():
        return sweep_figure(columns, over, **options)


def diagram(figure: Figure, words: str) -> Axes:
    (axes,) = (axes for axes in figure.axes if words in axes.get_ylabel())
    return axes


def legend(figure: Figure) -> list[str]:
    return [text.get_text() for text in figure.legends[0].get_texts()] if figure.legends else []


def test_diagrams_and_legend() -> None:
    figure = drawn(table(), OVER, title="A sweep_of $two")
    assert [axes.get_ylabel().split("$")[0].split(" (")[0].strip() for axes in figure.axes if axes.get_visible()] == [
        "frictional heat", "contact area ratio", "max. rise", "creep force"]  # fmt: skip
    assert legend(figure) == ["lower radius y = 15 mm", "lower radius y = 30 mm", WITHOUT]
    assert figure.axes[-1].get_xlabel() == "rolling speed (m/s)" or figure.axes[3].get_xlabel() == "rolling speed (m/s)"


@pytest.mark.parametrize(("count", "rows"), [(4, [2, 2]), (5, [3, 2]), (7, [3, 2, 2])])
def test_diagrams_fill_all_rows(count: int, rows: list[int]) -> None:
    names = [name for name in ALL_SCALARS if name.endswith("_N")][:count]
    figure = drawn(table(**{name: [1.0 + row for row in range(8)] for name in names}), OVER, only=names)
    figure.draw_without_rendering()
    feet = [round(axes.get_window_extent().y0) for axes in figure.axes]
    assert [len([*group]) for _, group in itertools.groupby(feet)] == rows
    assert sum(axes.get_tightbbox().x1 > 0.97 * figure.bbox.width for axes in figure.axes) == len(rows)


def test_a_share_has_no_band_outside_zero_and_one() -> None:
    columns = table(gamma_st=[0.02] * 4 + [0.99] * 4, **{"uncertainty.gamma_st": [0.2] * 8})
    axes = diagram(drawn(columns, OVER), "stick")
    bands = np.vstack([path.vertices for band in axes.collections for path in band.get_paths()])[:, 1]
    assert (bands.min(), bands.max()) == (0.0, 1.0)
    assert axes.get_ylim()[0] >= -0.05 and axes.get_ylim()[1] <= 1.05


@pytest.mark.parametrize(("name", "lowest"), [("pressure_max_MPa", 0.0), ("force_x_N", -100.0)])
def test_largest_values_have_no_band_below_zero(name: str, lowest: float) -> None:
    columns = table(**{name: [300.0] * 4 + [200.0] * 4, f"uncertainty.{name}": [300.0] * 8})
    axes = diagram(drawn(columns, OVER), ALL_SCALARS[name].diagram)
    bands = np.vstack([path.vertices for band in axes.collections for path in band.get_paths()])[:, 1]
    assert bands.min() == lowest and (axes.get_ylim()[0] > -60.0) == (lowest == 0.0)


@pytest.mark.parametrize("names", [("shift_x_um", "shift_y_um"), ("track_force_y_left_N", "track_force_y_right_N"),
                                   ("axial_stiffness_N_um", "radial_stiffness_N_um")])  # fmt: skip
def test_quantities_of_either_sign_keep_theirs(names: tuple[str, str]) -> None:
    """Only what both bodies have shares a diagram."""
    columns = table(**{names[0]: [-3.0, -2.0, 1.0, 2.0] * 2, names[1]: [4.0, 5.0, 6.0, 7.0] * 2})
    figure = drawn(columns, OVER)
    curves = {tuple(line.get_ydata()) for axes in figure.axes for line in axes.lines}
    assert curves >= {(-3.0, -2.0, 1.0, 2.0), (4.0, 5.0, 6.0, 7.0)}
    assert all("max." in label for label, shown in DIAGRAMS.items() if len(shown) > 1)


def test_diagrams_above_each_other_have_the_same_axis() -> None:
    """Also where one knows fewer points: only the lowest have numbers."""
    columns = table(force_x_N=[math.nan, 15.0, 14.0, 13.0] * 2, contact_area_mm2=[1.0, 2.0, 3.0, 4.0] * 2)
    assert len({axes.get_xlim() for axes in drawn(columns, OVER).axes if axes.get_visible()}) == 1


def test_both_bodies_are_drawn_where_they_differ() -> None:
    """Each stress belongs to the depth of its own body."""
    stress, depth = ([f"von_mises_{what}_{body}" for body in ("lower", "upper")] for what in ("max", "depth"))
    columns = table(**{f"{stress[0]}_MPa": [551.0] * 8, f"{stress[1]}_MPa": [592.0] * 8, f"{depth[0]}_mm": [0.0453] * 8,
                       f"{depth[1]}_mm": [0.0417] * 8, "temperature_rise_max_upper_K": table()["temperature_rise_max_lower_K"]})
    figure = drawn(columns, OVER)
    for words, lower, upper in (("max. von Mises", 551.0, 592.0), ("depth of max. von Mises", 0.0453, 0.0417)):
        (axes,) = (axes for axes in figure.axes if axes.get_ylabel().startswith(words))
        hollow = {line.get_ydata()[0]: line.get_markerfacecolor() == "white" for line in axes.lines}
        assert hollow == {lower: False, upper: True}
    assert len(diagram(figure, "max. rise").lines) == 2  # one of each radius
    assert [words for words in legend(figure) if "body" in words] == ["lower body", "upper body"]


def test_a_force_given_as_zero_has_no_diagram_of_its_noise() -> None:
    columns = table(force_x_N=[1e-9, -3e-10, 2e-9, 1e-9] * 2, force_y_N=[0.0] * 8, friction_limit_N=[20.0] * 8,
                    **{"uncertainty.force_x_N": [4e-6] * 8})
    assert not any("creep force" in axes.get_ylabel() for axes in drawn(columns, OVER).axes)
    columns["force_x_N"] = [value * 1e6 for value in columns["force_x_N"]]
    assert any("creep force" in axes.get_ylabel() for axes in drawn(columns, OVER).axes)
    # A symmetry that the grid keeps to a hundred thousandth of what friction carries.
    columns["uncertainty.force_x_N"] = [1e-2] * 8
    assert not any("creep force" in axes.get_ylabel() for axes in drawn(columns, OVER).axes)


def test_a_force_per_length_counts_over_its_own_limit() -> None:
    """Of a contact and a line contact in one sweep each has an axis of F/(μW) of its own."""
    half = [math.nan] * 4
    columns = table(force_x_N=[10.0, 15.0, 19.0, 20.0, *half], friction_limit_N=[20.0] * 4 + half,
                    force_x_N_mm=[*half, 1.0, 2.0, 3.0, 4.0], friction_limit_N_mm=[*half, *[4.0] * 4])
    figure = drawn(columns, OVER)
    for unit, limit in (("N", 20.0), ("N/mm", 4.0)):
        axes = diagram(figure, f"creep force $F_x$ ({unit})")
        right, = (child for child in axes.child_axes)
        figure.draw_without_rendering()
        assert axes.get_ylim() == pytest.approx([limit * end for end in right.get_ylim()])


def test_a_map_is_of_one_body() -> None:
    places = [(speed, load) for speed in range(1, 7) for load in range(1, 6)]
    columns: dict[str, list[Any]] = {
        "rolling.speed_m_s": [float(speed) for speed, _ in places], "load.normal_N": [float(load) for _, load in places],
        "status": ["converged"] * 30, "von_mises_max_lower_MPa": [551.0 + load for _, load in places],
        "von_mises_max_upper_MPa": [592.0 + speed for speed, _ in places]}
    figure = drawn(columns, ["rolling.speed_m_s", "load.normal_N"])
    maps = {axes.get_title(): axes.collections[0].get_array() for axes in figure.axes if axes.get_title()}
    assert [*maps] == [f"max. von Mises stress (MPa), {body} body" for body in ("lower", "upper")]
    assert [float(values.max()) for values in maps.values()] == [556.0, 598.0]


def test_what_is_zero_everywhere_has_no_diagram() -> None:
    figure = drawn(table(gamma_st=[0.0] * 8, tilt_mrad=[0.0] * 8, **{"uncertainty.gamma_st": [1e-5] * 8}), OVER)
    assert not any(word in axes.get_ylabel() for axes in figure.axes for word in ("stick", "tilt"))


def test_a_ratio_that_is_one_within_its_error_has_no_diagram() -> None:
    """Without anything that acts back a grid's own noise is all that it shows."""
    values = [0.985 + 0.001 * place for place in range(8)]
    for error, diagrams in ((0.02, 0), (0.01, 1)):
        figure = drawn(table(gamma_c=values, **{"uncertainty.gamma_c": [error] * 8}), OVER)
        assert sum("contact area" in axes.get_ylabel() for axes in figure.axes) == diagrams


@pytest.mark.slow
def test_the_key_with_most_values_is_the_axis(monkeypatch: pytest.MonkeyPatch, tmp_path: pathlib.Path) -> None:
    """Curves are those of the other keys, in the order in which they are given."""
    columns = table()
    columns["load.normal_N"] = [2.0, 1.0] * 4
    orders: list[list[str]] = []

    def noted(table: dict[str, list[Any]], over: list[str], **options: Any) -> Figure:
        orders.append(over)
        return sweep_figure(table, over, **options)

    monkeypatch.setattr(table_picture, "sweep_figure", noted)
    assert draw_table(Columns(columns, names := (*OVER, "load.normal_N"), names), tmp_path / "a.png", dpi=30) == ""
    assert orders == [["rolling.speed_m_s", "geometry.lower_radius_y_mm", "load.normal_N"]]
    assert legend(drawn(columns, orders[0]))[:2] == ["lower radius y = 15 mm, normal load = 2 N",
                                                     "lower radius y = 15 mm, normal load = 1 N"]


def test_a_given_force_has_no_diagram_but_the_creepage_that_it_needs() -> None:
    needed = [0.001 + 1e-6 * speed for speed in table()[OVER[0]]]
    labels = [axes.get_ylabel() for axes in drawn(table(creepage_longitudinal=needed), OVER).axes if axes.get_visible()]
    assert any("creepage" in label for label in labels) and not any("force" in label for label in labels)


def test_every_line_of_a_sweep_has_a_colour_of_its_own() -> None:
    radii = [float(k) for k in range(1, 31)]
    rows = [(radius, speed) for radius in radii for speed in (10.0, 20.0, 50.0)]
    columns = {OVER[0]: [v for _, v in rows], OVER[1]: [r for r, _ in rows], "Q_F_W": [r * v for r, v in rows]}
    figure = drawn(columns, OVER)
    assert len({line.get_color() for line in figure.axes[0].get_lines()}) == 30
    assert len(legend(figure)) == 10


def test_two_keys_of_many_values_are_a_map() -> None:
    rows = list(itertools.product(np.geomspace(1.0, 100.0, 6), np.linspace(0.1, 0.5, 5)))
    columns: dict[str, Any] = {OVER[0]: [v for v, _ in rows], "load.friction_coefficient": [f for _, f in rows],
                               "Q_F_W": [v * f for v, f in rows], "status": ["converged"] * 30}  # fmt: skip
    columns["status"][7] = "not_converged"
    figure = drawn(columns, [OVER[0], "load.friction_coefficient"])
    axes = figure.axes[0]
    (mesh,) = (found for found in axes.collections if hasattr(found, "get_coordinates"))
    values = np.ma.filled(np.ma.asarray(mesh.get_array()).reshape(5, 6), np.nan)
    assert values[4, 5] == pytest.approx(50.0) and np.isnan(values).sum() == 1
    (marks,) = (line for line in axes.get_lines() if line.get_marker() == "x")
    assert [marks.get_xdata()[0], marks.get_ydata()[0]] == list(rows[7])
    assert axes.get_xscale() == "log" and axes.get_yscale() == "linear"
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("rolling speed (m/s)", "friction coefficient")


def test_failed_points_are_marked_where_they_were_asked_for() -> None:
    columns = table()
    columns["status"][3] = columns["status"][7] = "not_converged"
    figure = drawn(columns, OVER)
    axes = figure.axes[0]
    marks = [line for line in axes.get_lines() if line.get_marker() == "x"]
    curves = [line for line in axes.get_lines() if line not in marks]
    assert [list(line.get_xdata()) for line in marks] == [[100.0], [100.0]]
    assert [mark.get_color() for mark in marks] == list(dict.fromkeys(curve.get_color() for curve in curves))
    assert marks[0].get_ydata()[0] < marks[1].get_ydata()[0], "one cross covers the other"
    assert max(x for line in curves for x in line.get_xdata()) == 50.0
    assert "not converged" in legend(figure)


def test_peaks_without_a_limit_are_marked() -> None:
    columns = table(pressure_max_MPa=[100.0 * row for row in range(1, 9)])
    columns["unbounded"] = ["", "pressure_max_MPa shear_max_MPa", *[""] * 6]
    figure = drawn(columns, OVER)
    rings = {axes.get_ylabel(): [list(line.get_ydata()) for line in axes.get_lines() if line.get_markerfacecolor() == "white"]
             for axes in figure.axes}
    assert rings.pop("max. pressure (MPa)") == [[200.0]] and not any(rings.values())
    assert "no limit" in legend(figure)


def test_errors_are_bands() -> None:
    columns = table(gamma_st=[0.5] * 8, **{"uncertainty.gamma_st": [0.01] * 8, "uncertainty.Q_F_W": [0.01] * 8})
    figure = drawn(columns, OVER)
    for words, low, high in (("gamma_\\mathrm{st}", 0.49, 0.51), ("frictional heat", columns["Q_F_W"][0] - 0.01, None)):
        band = diagram(figure, words).collections[0].get_paths()[0].vertices
        assert band[:, 1].min() == pytest.approx(low)
        assert high is None or band[:, 1].max() == pytest.approx(high)


def test_an_axis_does_not_zoom_into_the_error_of_its_numbers() -> None:
    wobbling = [0.5 + 1e-3 * (-1) ** row for row in range(8)]
    figure = drawn(table(gamma_st=wobbling, **{"uncertainty.gamma_st": [0.01] * 8}), OVER)
    low, high = diagram(figure, "gamma_\\mathrm{st}").get_ylim()
    assert high - low >= 6.0 * 0.01


def test_states_that_coincide_are_one_curve() -> None:
    """Ratios that only heat can change, and a state without heat equal to the one with it, are not drawn."""
    columns = table(gamma_c=[1.0] * 8, gamma_p=[1.0] * 8)
    columns["isothermal.Q_F_W"] = [1.0005 * value for value in columns["Q_F_W"]]
    figure = drawn(columns, OVER)
    assert not any("gamma" in axes.get_ylabel() for axes in figure.axes)
    assert WITHOUT not in legend(figure) and len(diagram(figure, "frictional heat").get_lines()) == 2


@pytest.mark.slow
def test_forces_are_also_shown_over_the_friction_limit() -> None:
    columns = table(force_x_N=[float(row) for row in range(8)], friction_limit_N=[20.0] * 8)
    figure = drawn(columns, OVER)
    axes = diagram(figure, "F_x")
    figure.draw_without_rendering()
    (right,) = axes.child_axes
    assert right.get_ylim() == pytest.approx([limit / 20.0 for limit in axes.get_ylim()])
    assert right.get_ylabel() == r"$F_x/(\mu W)$"
    varying = drawn(columns | {"friction_limit_N": [20.0 + row for row in range(8)]}, OVER)
    assert not any(axes.child_axes for axes in varying.axes)


def creep_curve() -> dict[str, list[Any]]:
    c = creepage_coefficients(1.5, 0.28)
    creepage = [1e-4, 1e-3, 3e-3, 1e-2]
    ones = {"hertz_a_mm": 6.0, "hertz_b_mm": 4.0, "shear_modulus_GPa": 82.0, "friction_limit_N": 25e3, "kalker_C11": c.c11,
            "kalker_C22": c.c22, "kalker_C23": c.c23, "creepage_lateral": 0.0, "creepage_spin_rad_mm": 0.0}  # fmt: skip
    return {"creepage.longitudinal": creepage, "creepage_longitudinal": creepage, "force_x_N": [8e2, 7e3, 1.7e4, 2.5e4],
            "status": ["converged"] * 4, **{name: [value] * 4 for name, value in ones.items()}}  # fmt: skip


def test_creep_curves_stand_beside_simplified_theories() -> None:
    columns = creep_curve()
    figure = drawn(columns, ["creepage.longitudinal"], compare=["linear", "polach", "fastsim"])
    assert legend(figure) == ["Polach", "FASTSIM", "Kalker's linear theory"]
    axes = diagram(figure, "F_x")
    _, polach, fastsim, linear = axes.get_lines()
    expected = [linear_creep_forces(creepage_coefficients(1.5, 0.28), 6e-3, 4e-3, 82e9, x).force_x
                for x in columns["creepage.longitudinal"]]
    # Theories are drawn between the points, too: the linear one is a straight line, FASTSIM no polygon.
    assert list(linear.get_ydata()[::12]) == pytest.approx(expected)
    middle = 0.5 * sum(columns["creepage.longitudinal"][:2])
    assert np.interp(middle, *linear.get_data()) == pytest.approx(0.5 * sum(expected[:2]))
    assert np.interp(middle, *fastsim.get_data()) > 1.001 * 0.5 * (fastsim.get_ydata()[0] + fastsim.get_ydata()[12])
    looks = {str(line.get_linestyle()) + str(line._dash_pattern) for line in (polach, fastsim, linear)}
    assert len(looks) == 3
    for curve in (polach, fastsim):
        assert curve.get_ydata()[0] == pytest.approx(expected[0], rel=0.1) and max(curve.get_ydata()) <= 25e3 * (1.0 + 1e-12)
    assert axes.get_ylim()[1] < max(expected), "the linear law does not stretch the axis"


def test_comparisons_that_cannot_be_made_say_why() -> None:
    with pytest.raises(ValueError, match="linear, fastsim, polach, not 'contact'"):
        drawn(creep_curve(), ["creepage.longitudinal"], compare=["contact"])
    without = creep_curve() | {"hertz_a_mm": [float("nan")] * 4}
    with pytest.raises(ValueError, match="no numbers in hertz_a_mm"):
        drawn(without, ["creepage.longitudinal"], compare=["linear"])


def test_words_are_places_on_the_axis() -> None:
    columns = {"rolling.peclet": ["rolling", "sliding", "stationary"], "Q_F_W": [1.0, 2.0, 3.0]}
    figure = drawn(columns, ["rolling.peclet"])
    assert [text.get_text() for text in figure.axes[0].get_xticklabels()] == columns["rolling.peclet"]
    assert list(figure.axes[0].get_lines()[0].get_xdata()) == [0.0, 1.0, 2.0]


def test_between_words_there_is_nothing() -> None:
    columns = {"thermal.peclet": ["rolling", "stationary"], "Q_F_W": [1.0, 2.0], "uncertainty.Q_F_W": [0.1, 0.2],
               "isothermal.Q_F_W": [1.0, 1.5]}
    figure = drawn(columns, ["thermal.peclet"])
    axes = diagram(figure, "heat")
    with_heat, without = axes.get_lines()
    assert {(line.get_linestyle(), line.get_marker()) for line in (with_heat, without)} == {("None", "o"), ("None", "D")}
    (bars,) = axes.collections
    assert [segment.tolist() for segment in bars.get_segments()] == [[[0.0, 0.9], [0.0, 1.1]], [[1.0, 1.8], [1.0, 2.2]]]
    assert legend(figure) == [WITHOUT]


def test_a_table_read_from_csv_gives_the_same_picture(tmp_path: pathlib.Path) -> None:
    path, columns = tmp_path / "sweep.csv", table()
    write_csv(path, Columns(columns, tuple(OVER), tuple(OVER)))
    one, other = drawn(columns, OVER), drawn(dict(read_table(path).columns), OVER)
    for axes, same in zip(one.axes, other.axes, strict=True):
        assert [list(line.get_ydata()) for line in axes.get_lines()] == [list(line.get_ydata()) for line in same.get_lines()]


def test_a_table_is_drawn_in_python() -> None:
    columns, axes = Columns(table(), tuple(OVER), tuple(OVER)), Figure().subplots()
    assert [each.get_ylabel() for each in columns.plot().axes] == [each.get_ylabel() for each in drawn(table(), OVER).axes]
    assert columns.plot("temperature_rise_max_lower_K", x=OVER[1], ax=axes) is axes.figure
    assert axes.get_lines()[1].get_ydata().tolist() == [20.0 / 15.0, 20.0 / 30.0]
    assert (axes.get_xlabel(), len(axes.get_legend().get_texts())) == ("lower radius y (mm)", 4)
    for name, ax, reason in (("Q_W", None, "no column 'Q_W'"), ("", axes, "axes of yours take one column")):
        with pytest.raises(ValueError, match=reason):
            columns.plot(name, ax=ax)


def test_every_key_with_a_unit_can_be_swept_under_its_unit() -> None:
    keys = {name for table in case_schema()["$defs"].values() for name in table["properties"]}
    named = {name: unit_of(name) for name in keys if UNIT_AT_END.search(name)}
    assert len(named) > 20 and {name for name in keys if unit_of(name) not in ("", "K")} == {*named}
    assert named["yaw_rate_mrad_s"] == "mrad/s" and named["expansion_um_mK"] == "µm/(m K)"
    assert [name for name, unit in named.items() if not words_of(f"table.{name}").endswith(f"({unit})")] == []
    assert with_value("load.normal_N", 150e3) == "normal load = 150000 N"
    assert with_value("load.friction_coefficient", 0.25) == "friction coefficient = 0.25"
    assert with_value("geometry.lower_radius_y_mm", math.inf) == "lower radius y = ∞"


@pytest.mark.parametrize("top", sampled([40.0, 1e6]))
def test_numbers_on_a_logarithmic_axis_keep_apart(top: float) -> None:
    columns = {OVER[0]: list(np.geomspace(2.0, top, 5)), "Q_F_W": [1.0, 2.0, 3.0, 4.0, 5.0]}
    figure = drawn(columns, OVER[:1])
    figure.draw_without_rendering()
    axes = figure.axes[0]
    left, right = axes.get_xlim()
    boxes = [label.get_window_extent() for label, place in zip(axes.get_xticklabels(), axes.get_xticks(), strict=True)
             if left <= place <= right and label.get_text()]
    assert len(boxes) >= 2
    assert all(a.x1 < b.x0 for a, b in itertools.pairwise(boxes))


@pytest.mark.slow
def test_points_without_numbers_are_left_out(tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(plot_style, "DPI", 40)
    columns = table()
    columns["Q_F_W"][1:4] = [None, "", float("nan")]
    columns["gamma_c"] = [None] * 8
    columns["isothermal.gamma_c"] = [float("nan")] * 8
    only_failures = {OVER[0]: [1.0, 2.0], "Q_F_W": [None, None]}
    one_point = {OVER[0]: [1.0], "Q_F_W": [2.5]}
    for name, wanted in (("a.svg", columns), ("b.png", only_failures), ("c.png", one_point)):
        assert plot_style.save(drawn(wanted, OVER[:1]), tmp_path / name).exists()


def test_a_figure_over_nothing_is_refused() -> None:
    for over in ([], ["load.normal_N"], ["status"]):
        with pytest.raises(ValueError):
            drawn(table(), over)


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
    assert words_of("bearing.load.radial_N") == "radial load (N)"
    assert words_of("load.friction_coefficient") == "friction coefficient"
    assert words_of("force.lateral_N") == "lateral force (N)"


def test_an_animation_has_a_frame_for_each_point(tmp_path: pathlib.Path) -> None:
    """In the order of the values, whatever that of the points, and only for what can move."""
    (tmp_path / "a.toml").write_text(THERMAL, encoding="utf-8")
    swept = ("sweep", "a.toml", "--no-plots", "-q", "--set", "numerics.grid=8")
    assert call(*swept, "--over", "creepage.longitudinal=0.003,0.0005", "-o", "s", cwd=tmp_path).returncode == 0
    done = call("plot", "s/sweep.csv", "--animate", "creepage.longitudinal", cwd=tmp_path, painted=True)
    assert (done.returncode, pathlib.Path(done.stdout.strip())) == (0, pathlib.Path("s/sweep.gif"))
    with Image.open(tmp_path / "s" / "sweep.gif") as image:
        assert image.n_frames == 2 and image.size == (590, 259)
        frames = [np.asarray((image.seek(number), image.convert("RGB"))[1], dtype=int) for number in range(2)]
    assert all(np.abs(one - other).any() for one, other in itertools.combinations(frames, 2))
    wrong = call("plot", "s/sweep.csv", "--animate", "load.normal_N", cwd=tmp_path)
    assert wrong.returncode == 2 and "was not swept" in wrong.stderr
    assert call("plot", "s/a_0001.h5", "--animate", "load.normal_N", cwd=tmp_path).returncode == 2
    (tmp_path / "words.csv").write_text("case,load.normal_N,status\na,60,converged\nb,60,converged\n")
    wrong = call("plot", "words.csv", "--animate", "case", cwd=tmp_path)
    assert wrong.returncode == 2 and "case has words, such as a" in wrong.stderr
    (tmp_path / "s" / "a_0002.h5").unlink()
    assert call("plot", "s/sweep.csv", "--animate", "creepage.longitudinal", cwd=tmp_path).returncode == 5
    assert call(*swept, "--over", "creepage.longitudinal=0.001,0.002", "--scalars-only", "-o", "t",
                cwd=tmp_path).returncode == 0  # fmt: skip
    wrong = call("plot", "t/sweep.h5", "--animate", "creepage.longitudinal", cwd=tmp_path)
    assert wrong.returncode == 2 and "scalars-only" in wrong.stderr


def test_a_sweep_of_wheelsets_has_words_at_its_axis() -> None:
    columns = {"wheelset.lateral_shift_mm": [0.0, 3.0], "track_force_y_left_N": [1.0, 2.0], "status": ["converged"] * 2}
    figure = wheelset_sweep_figure(columns, "wheelset.lateral_shift_mm", "")
    assert figure.axes[-1].get_xlabel() == "lateral shift (mm)"


def test_columns_that_are_named_are_drawn_of_wheelsets_too(tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch) -> None:
    drawn: list[Figure] = []
    monkeypatch.setattr(plot_style, "save", lambda figure, *_: drawn.append(figure))
    shift = "wheelset.lateral_shift_mm"
    table = Columns({shift: [0.0, 3.0, 6.0], "status": ["converged"] * 3, "track_force_y_left_N": [1.0, 2.0, 3.0],
                     "temperature_rise_max_K": [4.0, 40.0, 190.0], "left_1.y_rail_mm": [-10.0, -5.0, -3.0],
                     "left_1.normal_N": [1.0, 2.0, 3.0]}, (shift,), (shift,))
    assert draw_table(table, tmp_path / "a.png", only=["temperature_rise_max_K"]) == draw_table(table, tmp_path / "a.png") == ""
    asked, usual = ([axes.get_ylabel() for axes in figure.axes] for figure in drawn)
    assert len(asked) == 1 and asked[0].startswith("maximum temperature rise") and usual[0].startswith("y on the rail")
