"""docs/benchmarks.md from benchmarks/results.json."""

from __future__ import annotations

import statistics
from collections.abc import Callable, Sequence
from typing import Any

from scripts.figures.figures_tables import markdown

NAMES = {"article_4_1": "Sec. 4.1, coupled", "article_4_1_mechanical": "Sec. 4.1, isothermal",
         **{f"article_3_1_case_{n}": f"Sec. 3.1, case {n}" for n in range(1, 6)},
         "article_3_1_case_5_spin_reversed": "Sec. 3.1, case 5, spin reversed"}

INTRODUCTION = """# Run time against error

Written by `make bench` from `benchmarks/results.json`; do not edit. All times are medians of repeated solves on one thread,
from nothing: no kernel and no plan is kept between them. Times in other columns than "processor" are elapsed and suffer from
whatever else the machine does; ratios are taken between runs that alternate.
From N = 512 on fewer runs are made than stated (one, for all isothermal cases but one).

True errors are against N = 1024, extrapolated (`benchmarks/references.json` by `scripts/references/bench_references.py`).
Errors below about 1e-5, and those at N = 512, are of the size of the reference's own. `γ_st` errors are absolute, forces are
over μW, the rest is relative.
"""


def _table(header: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    return markdown({"header": list(header), "rows": [list(row) for row in rows]}) + "\n"


def _error(value: float | None) -> str:
    return "—" if value is None or value != value else f"{value:.1e}"


def _seconds(value: float) -> str:
    return f"{value:.3g}"


def _machine(part: dict[str, Any]) -> str:
    m = part["machine"]
    busy = "" if m["load"] < 1.5 else f" **The machine was busy (load {m['load']:.1f}): times are rough.**"
    return f"Measured on {m['processor']}, {m['cores']} cores, Python {m['python']}, {m['runs']} runs.{busy}\n\n"


def page(results: dict[str, Any]) -> str:
    """The whole document; parts without numbers are left out."""
    writers: dict[str, Callable[[Any, str], str]] = {
        "accuracy": _accuracy, "baselines": _baselines, "frictionless": _frictionless, "transforms": _transforms,
        "points": _points, "startup": _startup, "plain_start": _plain_start, "scaling": _scaling, "memory": _memory,
    }
    text = INTRODUCTION + "\n"
    for name, write in writers.items():
        if name in results:
            text += write(results[name]["measured"], _machine(results[name]))
    return text.rstrip() + "\n"


def _accuracy(measured: dict[str, Any], machine: str) -> str:
    text = "## The article's cases\n\n" + machine
    text += "![Error against time](../benchmarks/error_against_time.png)\n\n"
    text += "Median / largest true error of the seven isothermal cases, and the median of the estimates beside it:\n\n"
    rows = []
    isothermal = [r for r in measured["rows"] if r["case"] != "article_4_1"]
    for grid in sorted({r["N"] for r in isothermal}):
        some = [r for r in isothermal if r["N"] == grid]
        cells = [str(grid), _seconds(statistics.median(r["cpu_seconds"] for r in some))]
        for name in ("forces", "Q_F_W", "gamma_st"):
            errors = [r["error"][name] for r in some]
            estimates = [r["estimate"][name] for r in some]
            cells += [f"{_error(statistics.median(errors))} / {_error(max(errors))}", _error(statistics.median(estimates))]
        rows.append([*cells, str(max(r["applications"] for r in some))])
    text += _table(("N", "processor s", "forces", "est.", "Q_F", "est.", "γ_st", "est.", "applications"), rows)
    text += "Against `rolling_fine.json`, largest distance beyond the uncertainty which that file states for itself:\n\n"
    rows = []
    for grid in (32, 64, 128):
        some = [r["against_fine_reference"] for r in isothermal if r["N"] == grid]
        rows.append([str(grid), *(_error(max(max(0.0, s["distance"][k] - s["uncertainty"][k]) for s in some))
                                  for k in ("force_x", "force_y", "heat", "stick"))])
    text += _table(("N", "F_x / μW", "F_y / μW", "Q_F", "γ_st"), rows)
    text += "The coupled case (true error, estimate):\n\n"
    names = ("Q_F_W", "forces", "gamma_c", "gamma_st", "gamma_p", "temperature_rise_max_lower_K")
    rows = [[str(r["N"]), _seconds(r["cpu_seconds"]),
             *(f"{_error(r['error'][k])}, {_error(r['estimate'][k])}" for k in names)]
            for r in measured["rows"] if r["case"] == "article_4_1"]
    text += _table(("N", "processor s", "Q_F", "forces", "γ_c", "γ_st", "γ_p", "ΔT_max"), rows)
    text += "![Estimate beside true error](../benchmarks/estimate_beside_error.png)\n\n"
    return text + _against_contact(measured["against_contact"])


IN_TURN = {"N = 64": 10, "N = 128": 70, "N = 256": 500}
"""CONTACT's processor seconds over ours at equal error, both measured in alternation, with an earlier state of this program."""


def _against_contact(levels: dict[str, Any]) -> str:
    there = {name: level for name, level in levels.items() if level["rows"]}
    told = [name for name in IN_TURN if name in there]
    ratios, here = ([f"{value:.0f}" for value in values] for values in (
        (IN_TURN[name] for name in told), (there[name]["median"] for name in told)))
    apart = [there[name]["median"] / IN_TURN[name] for name in told]
    text = ("### Against CONTACT\n\nOurs is the coarsest grid whose forces are no worse than CONTACT's, at its default "
            "tolerance; seconds are those of the solution alone, without the start of a process on either side. **Measured in "
            f"turn, on one shared core, with an earlier state of this program, CONTACT took {', '.join(ratios)} times as long "
            f"at its {', '.join(told)}.** Our seconds below are of this run and machine, CONTACT's of that one "
            "(`tests/reference/contact_side_by_side.json`), which was another. Their quotients, in the median "
            f"{', '.join(here)}, are {min(apart):.1f} to {max(apart):.1f} times the ratios measured in turn: the other machine "
            "and what has changed in the program since, which cannot be told apart. Compare within the columns.\n\n")
    for name, level in there.items():
        text += f"CONTACT with {name}, median quotient {level['median']:.0f}:\n\n"
        text += _table(("case", "CONTACT s, there", "its error", "our N", "our s, here", "our error", "quotient"), [
            [NAMES[r["case"]], _seconds(r["contact_seconds"]), _error(r["contact_error"]), str(r["N"]), f"{r['seconds']:.4f}",
             _error(r["error"]), f"{r['ratio']:.0f}"] for r in level["rows"]])
    return text + ("Pure spin (case 3) has no reference good to more than about 4e-4 μW: CONTACT on eleven grids, its "
                   "extrapolation from two, `rolling_fine.json` and this program differ by 4e-4 … 7e-4 μW "
                   "([tests/reference/README.md](../tests/reference/README.md)).\n\n")


def _baselines(rows: list[dict[str, Any]], machine: str) -> str:
    text = "## One idea taken away at a time\n\n" + machine
    text += ("The baselines live in `benchmarks/baselines/`: \"first-order discretisation\" is CONTACT's, upstream "
             "differences and whole elements; without continuation there is one grid and a cold start; GMRES without "
             "preconditioner is never restarted. Unpreconditioned GMRES is left out above N = 128.\n\n")
    text += "![Baselines](../benchmarks/baselines.png)\n\n"
    table = []
    for r in rows:
        if "failed" in r:
            table.append([NAMES[r["case"]], str(r["N"]), r["solver"], "failed", "", "", "", ""])
            continue
        table.append([NAMES[r["case"]], str(r["N"]), r["solver"], _seconds(r["seconds"]), f"{r['ratio']:.2f}",
                      str(r["applications"]), _error(r["error"]["forces"]), _error(r["error"].get("Q_F_W"))])
    return text + _table(("case", "N", "solver", "s", "time / thermoroll's", "applications", "forces", "Q_F"), table)


def _frictionless(rows: list[dict[str, Any]], machine: str) -> str:
    text = "## Frictionless contact, with other programs\n\n" + machine
    text += ("Hertz contact in free space on equal grids. Each solver gets the loosest tolerance with which it comes within "
             "1e-6 of the solution of its own discrete equations, which are the same for all. Kernels and plans are made "
             "beforehand. \"thermoroll\" starts from Hertz's pressure "
             "as the pipeline does, \"thermoroll-flat\" from a constant one like the others.\n\n")
    own = {r["N"]: r["seconds"] for r in rows if r["solver"] == "thermoroll"}
    table = []
    for r in rows:
        if "failed" in r:
            table.append([str(r["N"]), r["solver"], r["failed"], "", "", ""])
        else:
            table.append([str(r["N"]), r["solver"], f"{1e3 * r['seconds']:.3g}", f"{r['seconds'] / own[r['N']]:.3g}",
                          _error(r["tolerance"]), _error(r["peak_error"])])
    return text + _table(("N", "solver", "ms", "time / thermoroll's", "tolerance", "error of p_max"), table)


def _transforms(measured: dict[str, Any], machine: str) -> str:
    text = "## Share of the Fourier transforms\n\n" + machine
    text += ("Processor time of the whole solve over that of the same plans executed as often with nothing in between, all "
             f"grids up to N = {measured['rows'][0]['N']}. Counted by operations, in units of a real 512² transform. "
             "\"Plain\" are two transforms there and two back per application in double precision on the whole padded plane: "
             "what the same applications would take without half the contact, single precision and rows of zeros left out.\n\n")
    header = ("case", "solve s", "transforms s", "ratio", "512² equivalents", "applications on the finest grid", "plain s",
              "solve / plain")
    text += _table(header, [
        [NAMES[r["case"]], _seconds(r["seconds"]), _seconds(r["transforms_alone"]), f"{r['ratio']:.2f}",
         f"{r['equivalents_512']:.0f}", str(r["applications"]), _seconds(r["plain_transforms_alone"]),
         f"{r['seconds'] / r['plain_transforms_alone']:.2f}"] for r in measured["rows"]])
    return text + f"Median ratio {measured['ratio']:.2f}; at most {measured['equivalents_512']:.0f} equivalents.\n\n"


def _startup(measured: dict[str, Any], machine: str) -> str:
    text = "## The whole process\n\n" + machine
    text += "`thermoroll run cases/article_4_1.toml` with HDF5 and pictures, against the imports alone. "
    text += "pyFFTW imports Dask where that is installed; thermoroll does without.\n\n"
    rows = []
    for name, r in measured.items():
        if name == "reached":
            continue
        if "failed" in r:
            rows.append([name, "failed", "", "", ""])
        else:
            rows.append([name, _seconds(r["seconds"]), f"{r['ratio']:.2f}", _seconds(r["cpu_seconds"]),
                         f"{r['cpu_ratio']:.2f}"])
    text += _table(("what", "elapsed s", "/ imports", "processor s", "/ imports"), rows)
    if "failed" not in measured["imports"]:
        alone = min(r["cpu_seconds"] for name, r in measured.items() if name.startswith("imports") and "failed" not in r)
        text += ("CONTACT's process takes 0.008 s more than its solution: about 0.03 s at its N = 22, 0.3 s at N = 64 and 2 to "
                 f"3 s at N = 128, on another machine. Our imports alone take {_seconds(alone)} s here: as a whole process "
                 "CONTACT is the faster one up to where its solution takes that long, N ≈ 64 and a little more.\n\n")
    reached = measured["reached"]
    met = "is met" if reached["converged"] else f"is not met ({reached['reason']})"
    return text + f"`accuracy = 1e-3` {met} on {reached['grid'][0]} × {reached['grid'][1]} elements.\n\n"


def _points(rows: list[dict[str, Any]], machine: str) -> str:
    text = "## Many creepages of one contact\n\n" + machine
    text += ("What a point costs in a table of creep forces, where 160 are solved together, beside the same points solved one "
             "after the other as in a sweep, each starting from its neighbour; in turn in one process. N of the finer of two "
             "grids. Differences are those of the forces of the finer grid over μW, beside the estimated error of forces.\n\n")
    header = ("N", "one after the other, ms", "together, ms", "ratio", "largest difference", "estimated error, rms")
    return text + _table(header, [
        [str(r["N"]), f"{r['alone_ms']:.2f}", f"{r['together_ms']:.2f}", f"{r['ratio']:.1f}", _error(r["largest_difference"]),
         _error(r["estimated_error_rms"])] for r in rows])


def _plain_start(measured: dict[str, Any], machine: str) -> str:
    text = "### Without heat and pictures\n\n" + machine
    text += ("Processor time of `thermoroll run --no-plots` for `cases/table1.toml` without heat, against "
             "`python -c \"import numpy, h5py\"`. The second row imports Typer and pydantic as well, which read the command "
             "line and the case; `thermoroll validate` needs no NumPy. The rest are modules of the program itself, FFTW, the "
             "solve on three grids, and the file.\n\n")
    return text + _table(("what", "processor s", "/ imports"), [
        [name, _seconds(r["cpu_seconds"]), f"{r['cpu_ratio']:.2f}"] for name, r in measured.items()])


def _scaling(measured: dict[str, Any], machine: str) -> str:
    text = "## Cost against N\n\n" + machine + "![Cost against N](../benchmarks/cost.png)\n\n"
    text += _table(("N", "elapsed s", "processor s", "μs per element", "applications", "runs"), [
        [str(r["N"]), _seconds(r["seconds"]), _seconds(r["cpu_seconds"]), f"{r['microseconds_per_element']:.2f}",
         str(r["applications"]), str(r["runs"])] for r in measured["rows"]])
    text += f"Time grows as elements^{measured['exponent']:.2f}"
    growth = measured["growth_per_element_from_128"]
    if growth:
        text += f"; per element by {growth:.2f} from N = 128 to {measured['rows'][-1]['N']}"
    return text + ".\n\n"


def _memory(rows: list[dict[str, Any]], machine: str) -> str:
    text = "## Memory\n\nPeak of a process of its own, imports included.\n\n"
    return text + _table(("case", "N", "GiB", "elapsed s", ""), [
        [NAMES[r["case"]], str(r["N"]), f"{r['peak_bytes'] / 2**30:.2f}", _seconds(r["seconds"]),
         "" if r["converged"] else r["reason"]] for r in rows])
