"""Figures of the benchmark: error against time, error and estimate against N, baselines, cost against N."""

from __future__ import annotations

import pathlib
from typing import Any

from matplotlib.axes import Axes
from matplotlib.ticker import NullFormatter

from thermoroll_cli.plots.sheet import add_axes, new_figure, save, style

OWN, OTHER, THIRD, FOURTH = "#0072b2", "#d55e00", "#009e73", "#cc79a7"
GREY = "0.45"
COLOURS = {"thermoroll": OWN, "first-order discretisation": OTHER, "no continuation": THIRD, "unpreconditioned GMRES": FOURTH}
FLOOR = 2e-7
HOT = "article_4_1"


def _log(axes: Axes, x: str, y: str, title: str) -> None:
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xlabel(x)
    axes.set_ylabel(y)
    axes.set_title(title, loc="left")
    axes.grid(True, which="major", linewidth=0.3, color="0.85")
    # Over less than a decade matplotlib writes numbers at small ticks, too, and over each other.
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_minor_formatter(NullFormatter())


def _grids(axes: Axes, grids: list[int]) -> None:
    axes.set_xticks(grids, [str(n) for n in grids])
    axes.minorticks_off()


def error_against_time(measured: dict[str, Any], path: pathlib.Path) -> None:
    """Isothermal cases: error of forces and heat against processor seconds, CONTACT's beside them."""
    figure = new_figure(7.2, 3.6)
    for place, (name, label) in enumerate((("forces", "error of the forces / μW"), ("Q_F_W", "relative error of Q_F"))):
        axes = add_axes(figure, 0.65 + 3.55 * place, 0.7, 2.75, 2.5)
        for index, row in enumerate([r for r in measured["rows"] if r["N"] == 16 and r["case"] != HOT]):
            own = [r for r in measured["rows"] if r["case"] == row["case"]]
            theirs = [r for r in measured["contact"] if r["case"] == row["case"]]
            axes.plot([r["cpu_seconds"] for r in own], [max(r["error"][name], FLOOR) for r in own], "o-", color=OWN,
                      markersize=2.5, linewidth=0.8, label=f"thermoroll, N = 16…{own[-1]['N']}" if index == 0 else None)
            axes.plot([r["cpu_seconds"] for r in theirs], [max(r["error"][name], FLOOR) for r in theirs], "s--", color=OTHER,
                      markersize=2.5, linewidth=0.8,
                      label="CONTACT (four of them, on another machine), N = 22…256" if index == 0 else None)
        _log(axes, "processor seconds", label, "Seven isothermal cases")
        if place == 0:
            # Below the diagrams: inside, it would lie over the slowest solutions.
            figure.legend(loc="lower center", fontsize=6.5, ncols=2)
    save(figure, path)


def estimate_beside_error(measured: dict[str, Any], path: pathlib.Path) -> None:
    """Error and estimate against N, for the scalars of an isothermal and of the coupled case."""
    panels = (("article_4_1_mechanical", "forces", "forces / μW"), ("article_4_1_mechanical", "Q_F_W", "Q_F"),
              (HOT, "Q_F_W", "Q_F, coupled"), (HOT, "gamma_p", "γ_p, coupled"), (HOT, "gamma_c", "γ_c, coupled"),
              (HOT, "temperature_rise_max_lower_K", "ΔT_max, coupled"))
    figure = new_figure(7.2, 4.9)
    for index, (case, name, title) in enumerate(panels):
        axes = add_axes(figure, 0.6 + 2.3 * (index % 3), 2.85 - 2.35 * (index // 3), 1.75, 1.7)
        rows = [r for r in measured["rows"] if r["case"] == case]
        grids = [r["N"] for r in rows]
        axes.plot(grids, [max(r["error"][name], FLOOR) for r in rows], "o-", color=OWN, markersize=3, label="true error")
        axes.plot(grids, [r["estimate"][name] for r in rows], "^--", color=OTHER, markersize=3, label="estimate")
        _log(axes, "N", "relative" if index % 3 == 0 else "", title)
        _grids(axes, grids)
        if index == 0:
            axes.legend(loc="upper right", fontsize=6.0)
    save(figure, path)


def baselines(rows: list[dict[str, Any]], path: pathlib.Path) -> None:
    """Error of the forces against seconds with one idea taken away at a time, and applications against N."""
    figure = new_figure(7.2, 3.4)
    case = "article_3_1_case_5"
    first = add_axes(figure, 0.65, 0.5, 2.75, 2.5)
    second = add_axes(figure, 4.2, 0.5, 2.75, 2.5)
    for name, colour in COLOURS.items():
        some = [r for r in rows if r["solver"] == name and r["case"] == case and "failed" not in r]
        if not some:
            continue
        look: dict[str, Any] = {"color": colour, "markersize": 3.0, "linewidth": 0.9, "label": name}
        first.plot([r["cpu_seconds"] for r in some], [max(r["error"]["forces"], FLOOR) for r in some], "o-", **look)
        second.plot([r["N"] for r in some], [r["applications"] for r in some], "o-", **look)
    _log(first, "processor seconds", "error of the forces / μW", "Creepages and spin (Sec. 3.1, case 5)")
    _log(second, "N", "applications on the finest grid", "Work")
    _grids(second, sorted({r["N"] for r in rows}))
    second.set_yticks([20, 50, 100, 200, 400], ["20", "50", "100", "200", "400"])
    second.minorticks_off()
    first.set_xticks([0.02, 0.05, 0.1, 0.2, 0.5], ["0.02", "0.05", "0.1", "0.2", "0.5"])
    first.legend(loc="upper right", fontsize=6.0)
    save(figure, path)


def cost(scaling: dict[str, Any], memory: list[dict[str, Any]], path: pathlib.Path) -> None:
    """Time per element and peak memory against N."""
    figure = new_figure(7.2, 3.0)
    first = add_axes(figure, 0.65, 0.5, 2.75, 2.1)
    second = add_axes(figure, 4.2, 0.5, 2.75, 2.1)
    grids = [r["N"] for r in scaling["rows"]]
    first.plot(grids, [r["microseconds_per_element"] for r in scaling["rows"]], "o-", color=OWN, markersize=3)
    first.set_xscale("log")
    first.set_ylim(0.0, 1.1 * max(r["microseconds_per_element"] for r in scaling["rows"]))
    first.set_xlabel("N")
    first.set_ylabel("μs per element")
    first.set_title(f"Isothermal solve: time ~ elements^{scaling['exponent']:.2f}", loc="left")
    first.grid(True, linewidth=0.3, color="0.85")
    _grids(first, grids)
    for case, label, colour in (("article_4_1_mechanical", "isothermal", OWN), (HOT, "coupled", OTHER)):
        some = [r for r in memory if r["case"] == case]
        second.plot([r["N"] for r in some], [r["peak_bytes"] / 2**30 for r in some], "o-", color=colour, markersize=3,
                    label=label)
    second.axhline(4.0, color=GREY, linewidth=0.9, linestyle=":")
    _log(second, "N", "GiB", "Peak memory of the process (dotted: 4 GiB)")
    _grids(second, sorted({r["N"] for r in memory}))
    second.set_yticks([0.1, 0.2, 0.5, 1, 2, 4], ["0.1", "0.2", "0.5", "1", "2", "4"])
    second.minorticks_off()
    second.legend(loc="upper left")
    save(figure, path)


def draw(results: dict[str, Any], folder: pathlib.Path) -> None:
    """All figures for which there are numbers."""
    with style():
        if "accuracy" in results:
            error_against_time(results["accuracy"]["measured"], folder / "error_against_time.png")
            estimate_beside_error(results["accuracy"]["measured"], folder / "estimate_beside_error.png")
        if "baselines" in results:
            baselines(results["baselines"]["measured"], folder / "baselines.png")
        if "scaling" in results and "memory" in results:
            cost(results["scaling"]["measured"], results["memory"]["measured"], folder / "cost.png")
