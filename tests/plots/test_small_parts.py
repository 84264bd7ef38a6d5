"""Parts of pictures that a glance does not check: the arrow of a legend, axes of animations, how deep a panel reaches."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
from matplotlib.figure import Figure

from tests.support import synthetic
from tests.support.command_line import MECHANICAL
from tests.support.problems import STEEL, elastic, rolling
from thermoroll_cli import Case
from thermoroll_cli.plots import animation
from thermoroll_cli.plots.maps import border_handles, colours_of
from thermoroll_cli.plots.pictures import figure
from thermoroll_cli.plots.run_frame import TEMPERATURE, frame_of
from thermoroll_cli.plots.subsurface_figures import subsurface_figure
from thermoroll_cli.problem.problem import Heating, Layer, SubsurfaceRequest
from thermoroll_cli.problem.result import Result
from thermoroll_cli.python_api import solve


def test_the_arrow_of_the_legend_is_symmetric_about_its_axis() -> None:
    *_, arrow = border_handles(frame_of(synthetic.result()), arrows=True)
    vertices = np.asarray(arrow.get_marker().vertices)  # type: ignore[attr-defined]
    assert vertices[:, 0].min() == -1.0 and vertices[:, 0].max() == 1.0
    mirrored = {(x, -y) for x, y in vertices.tolist()}
    assert mirrored == {(x, y) for x, y in vertices.tolist()}


def test_colours_of_both_signs_reach_equally_far() -> None:
    for low, high in ((-2.0, 1.0), (-1.0, 2.0)):
        norm = colours_of(TEMPERATURE, low, high)["norm"]
        assert (norm.vmin, norm.vcenter, norm.vmax) == (-2.0, 0.0, 2.0)


def test_a_line_of_an_animation_fills_its_axes() -> None:
    result, axes = synthetic.result(), Figure().subplots()
    line = replace(result.coupled, fields={name: result.coupled.fields[name][:, 32] for name in ("shear_x", "shear_y")})
    largest = float(np.hypot(*line.fields.values()).max())
    animation._line(axes, line, [line], largest)
    assert axes.get_xlim() == (1e3 * line.x[0], 1e3 * line.x[-1])
    drawn = axes.lines[0].get_xydata()
    np.testing.assert_allclose(drawn[[0, -1], 0], axes.get_xlim())
    assert drawn[:, 1].max() == 1e-6 * largest < axes.get_ylim()[1] < 1.1e-6 * largest


@cache
def heated() -> Result:
    """Two spheres that slide fast: their heat reaches a tenth of the depth of the stresses."""
    problem = rolling(grid=16, body=STEEL, creepage=(0.05, 0.0), speed=100.0, heating=Heating(deformation=False))
    return solve(replace(problem, subsurface=SubsurfaceRequest(("lower",), layers=16)))


def test_the_panel_of_temperatures_ends_behind_the_heated_skin() -> None:
    """At 1.25 times the first depth below the last one that has a hundredth of the largest rise."""
    frame = frame_of(heated())
    picture = subsurface_figure(frame, "lower")
    assert picture is not None
    below = heated().subsurface.bodies["lower"]  # type: ignore[union-attr]
    rise = np.abs(below.plane["temperature_rise"]).max(axis=1)
    skin = below.depths[1 + int(np.flatnonzero(rise > 0.01 * rise.max()).max())]
    bottom, top = picture.axes[2].get_ylim()
    assert 1.25 * skin < 0.7 * below.depths[-1]
    assert top == 0.0 and bottom == 1.25 * skin * frame.lengths[0].factor


def test_largest_stresses_over_depth_are_those_of_the_plane() -> None:
    """Beside the interfaces of a coating: von Mises and shear stresses."""
    coated = replace(elastic(0.28), layers=(Layer(2e-5, 300e9, 0.25),))
    problem = replace(rolling(grid=12, body=coated, creepage=(0.003, 0.0)), subsurface=SubsurfaceRequest(("lower",), layers=8))
    result = solve(problem)
    picture, plane = subsurface_figure(frame_of(result), "lower"), result.bodies["lower"].plane
    assert picture is not None
    assert picture.axes[3].get_xlabel().endswith("(MPa)")
    shear = np.hypot(plane["stress_xz"], plane["stress_yz"])
    for line, stress in zip(picture.axes[3].lines, (plane["von_mises"], shear), strict=False):
        np.testing.assert_allclose(np.asarray(line.get_xdata()), 1e-6 * stress.max(axis=1), rtol=1e-5)


def test_the_map_of_friction_lies_between_both_coefficients() -> None:
    law = {"friction.law": "exponential", "friction.limit_coefficient": 0.1, "friction.half_slip_m_s": 0.5}
    plain, falling = (solve(Case.parse(MECHANICAL).with_values(values)) for values in ({}, law))
    picture = figure(falling, "friction")
    assert picture is not None
    drawn = np.asarray(picture.axes[0].get_images()[0].get_array())
    assert 0.1 <= drawn.min() < drawn.max() <= 0.3
    assert figure(plain, "friction") is None
