"""Tables of the benchmark in docs/ (places `<!-- table benchmark NAME -->`) and its figure, from results.json."""

from __future__ import annotations

import statistics
from typing import Any

from scripts.benchmark.cases import HOT, ROOT
from scripts.benchmark.contact import ratios
from scripts.benchmark.kinds import POWER, PRESSURE
from scripts.figures.figures_documents import fill
from scripts.figures.figures_drawing import COUPLED, ISOTHERMAL, diagrams
from scripts.figures.figures_drawing import write as save
from thermoroll_cli.plots.style import applied
from thermoroll_cli.problem.scalar_errors import number

NAMES = {HOT: "Sec. 4.1, coupled", "article_4_1_mechanical": "Sec. 4.1, isothermal",
         **{f"article_3_1_case_{n}": f"Sec. 3.1, case {n}" for n in range(1, 6)}}


def write(results: dict[str, Any]) -> None:
    """Fill in all tables for which there are numbers, and draw the figure."""
    makers = {"accuracy": _accuracy, "contact": _contact, "taken_away": _taken_away, "frictionless": _frictionless,
              "rows": _rows, "processes": _processes, "positions": _positions, "asked": _asked,
              "over_time": _over_time, "kinds": _kinds}
    tables = {name: makers[name](part["measured"]) for name, part in results.items()}
    if "accuracy" in results:
        tables["coupled"] = _coupled(results["accuracy"]["measured"])
    if "contact" in results:
        with applied():
            _figure(results)
    tables["machine"] = _machine(results)
    fill(ROOT / "docs", {"benchmark": tables})


def _table(header: str, rows: list[list[str]]) -> dict[str, Any]:
    return {"header": header.split(" | "), "rows": rows}


def _asked(measured: list[dict[str, Any]]) -> dict[str, Any]:
    rows = [[f"{r['accuracy']:.0e}", r["asked"], f"{r['N']:g}", f"{r['applications']:.2g}", f"{r['cpu']:.2g}",
             f"{r['reached']} of {r['contacts']}"] for r in measured]
    return _table("accuracy | of | N | applications / those at N = 64 | CPU / that at N = 64 | reach it", rows)


def _over_time(measured: list[dict[str, Any]]) -> dict[str, Any]:
    rows = [[r["history"], str(r["N"]), str(r["steps"]), f"{r['seconds']:.2g}", f"{r['error']:.1e}", f"{r['applications']:.1f}",
             str(r["steady"]), f"{r['applications'] / r['steady']:.2f}"] for r in measured]
    return _table("history | N | steps | CPU s | error of the force over μW, rms | applications a step | steady | ratio", rows)


def _kinds(measured: list[dict[str, Any]]) -> dict[str, Any]:
    rows = [[r["name"], str(r["N"]), f"{r['seconds']:.2g}",
             *(f"{error:.0e}, " + (f"{estimate:.0e}" if estimate else "–") for error, estimate in (r[POWER], r[PRESSURE]))]
            for r in measured]
    return _table("problem | N | CPU s | power | largest pressure", rows)


def _digits(ratio: float) -> str:
    return f"{ratio:.0f}" if ratio >= 10.0 else f"{ratio:.2g}"


def _machine(results: dict[str, Any]) -> dict[str, Any]:
    rows = [[name.replace("_", " "), m["processor"], str(m["cores"]), m["python"], str(m["runs"]), f"{m['load']:.1f}"]
            for name, m in ((name, part["machine"]) for name, part in results.items())]
    return _table("part | processor | cores | Python | runs | load", rows)


def _accuracy(measured: list[dict[str, Any]]) -> dict[str, Any]:
    rows = []
    isothermal = [r for r in measured if r["case"] != HOT]
    for grid in sorted({r["N"] for r in isothermal}):
        some = [r for r in isothermal if r["N"] == grid]
        cells = [str(grid), f"{1e3 * statistics.median(r['seconds'] for r in some):.3g}"]
        for name in ("forces", "Q_F_W", "gamma_st"):
            found = [r["error"][name] for r in some]
            cells += [f"{statistics.median(found):.0e} / {max(found):.0e}",
                      f"{statistics.median(r['estimate'][name] for r in some):.0e}"]
        rows.append([*cells, str(max(r["applications"] for r in some))])
    return _table("N | CPU ms | forces | est. | Q_F | est. | γ_st | est. | applications", rows)


def _coupled(measured: list[dict[str, Any]]) -> dict[str, Any]:
    names = ("Q_F_W", "forces", "gamma_c", "gamma_st", "gamma_p", "temperature_rise_max_lower_K")
    rows = [[str(r["N"]), f"{1e3 * r['seconds']:.3g}", *(f"{r['error'][k]:.0e}, {r['estimate'][k]:.0e}" for k in names)]
            for r in measured if r["case"] == HOT]
    return _table("N | CPU ms | Q_F | forces | γ_c | γ_st | γ_p | ΔT_max", rows)


def _contact(measured: dict[str, Any]) -> dict[str, Any]:
    rows = []
    for grid, found in ratios(measured).items():
        solves, whole = ([r[kind] for r in found] for kind in ("solve", "process"))
        cells = [f"{_digits(statistics.median(v))} ({_digits(min(v))} … {_digits(max(v))})" for v in (solves, whole)]
        rows.append([grid, f"{statistics.median(r['contact_seconds'] for r in found):.2g}",
                     f"{statistics.median(r['contact_error'] for r in found):.0e}",
                     " or ".join(str(n) for n in sorted({r["N"] for r in found})), *cells])
    return _table("CONTACT's N | its CPU s | its error | our N | CPU, CONTACT / our solve | CPU, CONTACT / our process", rows)


def _positions(measured: list[dict[str, Any]]) -> dict[str, Any]:
    return _table("program | CPU ms of a position | largest difference of a force, over the load",
                  [[one["name"], f"{one['ms']:.0f}", f"{one['difference']:.0e}"] for one in measured])


def _taken_away(measured: list[dict[str, Any]]) -> dict[str, Any]:
    return _table("case | solver | CPU / thermoroll's | applications | error of forces", [
        [NAMES[r["case"]], r["solver"], f"{r['ratio']:.2f}", str(r["applications"]), f"{r['error']:.0e}"] for r in measured])


def _frictionless(measured: list[dict[str, Any]]) -> dict[str, Any]:
    own = {r["N"]: r["ms"] for r in measured if r["solver"] == "thermoroll"}
    return _table("N | solver | CPU ms | CPU / thermoroll's | tolerance | error of p_max", [
        [str(r["N"]), r["solver"], f"{r['ms']:.3g}", f"{r['ms'] / own[r['N']]:.2g}", f"{r['tolerance']:.0e}",
         f"{r['peak_error']:.1e}"] for r in measured])


def _rows(measured: list[dict[str, Any]]) -> dict[str, Any]:
    return _table("measured | CPU ms | beside | CPU ms | ratio (least … largest) | applications", [
        [r["name"], number(r["ms"], 3), r["beside"], number(r["beside_ms"], 3),
         f"{r['ratio']:.2f} ({r['least']:.2f} … {r['largest']:.2f})",
         f"{r['applications']:.2f}" if r.get("applications") else "–"] for r in measured])


def _processes(measured: list[dict[str, Any]]) -> dict[str, Any]:
    return _table("process | CPU s | peak memory, MiB", [
        [r["name"], f"{r['seconds']:.2f}", f"{r['peak'] / 2**20:.0f}"] for r in measured])


def _figure(results: dict[str, Any]) -> None:
    """Error of the forces against processor seconds: our solves and CONTACT's."""
    figure, (axes,) = diagrams(1, 1, (4.6, 2.5))
    for index, values in enumerate(results["contact"]["measured"].values()):
        for kind, error, look, label in (("solve", "error", "o-", "thermoroll, solve"), ("process", "error", "o:",
                                         "thermoroll, whole process"), ("contact", "contact_error", "s--", "CONTACT, process")):
            grids = [n for n in values[kind] if n.isdigit()]
            axes.loglog([values[kind][n] for n in grids], [values[error][n] for n in grids], look, markersize=3, linewidth=0.9,
                        color=COUPLED if kind == "contact" else ISOTHERMAL, label=None if index else label)
    axes.set(xlabel="processor time (s)", ylabel=r"error of the creep forces / $\mu W$")
    axes.legend(loc="center right")
    save(figure, ROOT / "docs" / "figures", "error_against_time")
