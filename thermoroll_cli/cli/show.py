"""`thermoroll show`: the meaning of a case, and the time and memory of solving it."""

from __future__ import annotations

from typing import Any

from thermoroll_cli.cli import options, streams
from thermoroll_cli.cli.tables import align, folded, with_remarks
from thermoroll_cli.files.case import Case, shown
from thermoroll_cli.problem.kinds import Planned, kind_of
from thermoroll_cli.problem.names import ALL_SCALARS
from thermoroll_cli.problem.problem import Problem
from thermoroll_cli.problem.scalar_errors import number

MEANINGS = {
    "contact_length_mm": "of the contact along rolling, coarsely",
    "contact_width_mm": "of the contact across rolling, all patches",
    "contact_angle_low_mrad": "least inclination across rolling",
    "contact_angle_high_mrad": "largest inclination across rolling",
    "contact_centre_mm": "middle of that width",
    "contact_pressure_MPa": "largest pressure, coarsely",
    "saturation_creepage": "about where the whole contact slides",
    "dundurs_beta": "couples pressure and shear",
    "thermal_crown_bound": "Λ at most: curvature of the tracks' thermal crowns over that of the gap",
    "expected_bulk_temperature_lower_K": "of full sliding, lower body",
    "expected_bulk_temperature_upper_K": "of full sliding, upper body",
    "biot_lower": "Biot number hR/k, lower body",
    "biot_upper": "Biot number hR/k, upper body",
    "felt_modulus_GPa": "E* of both surfaces as fast as they pass the contact",
}
"""Meanings of the numbers known before solving, where they are not those of scalars of a result."""


def show(
    case: options.OneCase,
    settings: options.Settings = None,
    as_json: options.AsJson = False,
    verbose: options.Trace = False,
) -> None:
    """Show what a case means and what would run.

    Inputs in the units of their keys and in SI, how profile files were read, Hertz and Péclet numbers, saturation
    creepage, and the plan: stages that run, stages that are skipped and why, expected memory and time.
    """
    read, task = options.read_task(case, settings, as_json=as_json)
    kind = kind_of(task)
    with options.recorded(case, as_json), options.solvable(read, str(case)):
        plan, facts, warnings = kind.known(task)
    if as_json:
        inputs = {item.key: {"value": _finite(item.value), "si": _finite(item.si), "unit": item.unit} for item in read.inputs}
        planned: dict[str, Any] = {} if plan is None else {
            "memory_bytes": _memory(read, plan), "seconds": plan.seconds,
            "picture_seconds": _picture_seconds(read.plots, task.contact, plan),
            "upper_bound": task.contact.numerics.accuracy is not None, **plan.in_words.record}
        surfaces = {"surfaces": {key: found.record() for key, found in read.surfaces.items()}} if read.surfaces else {}
        streams.write_json({"name": read.name, "inputs": inputs, "profiles": read.profiles, **surfaces, **facts,
                            "warnings": warnings, **planned})
        return
    width, title = streams.width(), read.settings.title
    lines = [*folded(read.name + (f" ({title})" if title else ""), width, indent=""), *_inputs(read, width)]
    if read.profiles:
        lines += "files as they were read", *with_remarks(
            [(key, read.readings[key].words(record)) for key, record in read.profiles.items()], width)
    if read.surfaces:
        lines += "surfaces", *with_remarks([(key, found.words(found.record())) for key, found in read.surfaces.items()], width)
    meanings = {name: scalar.meaning for name, scalar in ALL_SCALARS.items()} | MEANINGS | dict(kind.answer.meanings)
    lines += "known before solving", *with_remarks(
        [(name, number(value), meanings.get(name, "")) for name, value in facts.items()], width)
    if plan is not None:
        drawing, numerics = _picture_seconds(read.plots, task.contact, plan), task.contact.numerics
        asked = ", ".join(numerics.accuracy_of) or "forces, heat, temperatures and the largest pressure"
        upto = f" at most, until {asked} are good to {numerics.accuracy:g}" if numerics.accuracy is not None else ""
        pictures = f", {drawing:.2g} s of them for pictures" if drawing else ""
        seconds = 0.8 + plan.seconds + drawing  # Python, libraries and files take 0.8 s on one core
        said = plan.in_words
        lines += "plan", *with_remarks(said.stages, width), *(f"  {size}" for size in said.sizes)
        lines[-1] += upto
        lines += *(f"  {note}" for note in said.notes), (
            f"  {'at most ' if upto else ''}about {_memory(read, plan) / 2**20:.0f} MiB and {seconds:.2g} s{pictures}")
    streams.write(
        *lines, *(line for warning in warnings for line in folded(f"warning: {warning}", width)))


def _inputs(case: Case, width: int) -> list[str]:
    """Keys, values and values in SI below each other; what has none in SI may be long, and moves no column."""
    items = [(f"  {item.key}", shown(item.value), item.shown_si) for item in case.inputs if item.key != "title"]
    table = align([("inputs", "", "in SI"), *((key, value if si else "", si) for key, value, si in items)])
    start = max((len(key) for key, _, _ in items), default=0) + 4
    lines = [table[0][2:]]
    for line, (key, value, si) in zip(table[1:], items, strict=True):
        first, *more = [line[2:]] if si else folded(value, max(width - start + 2, 24), indent="") or [""]
        lines += [first] if si else [key.ljust(start - 2) + first, *(" " * start + text.strip() for text in more)]
    return lines


def _finite(value: Any) -> Any:
    """JSON has no infinity: "inf", as in the resolved case of a result file."""
    return "inf" if value == float("inf") else value


def _memory(case: Case, plan: Planned) -> int:
    """Memory of the whole process in bytes, 100 MiB of it for Python and libraries, 105 MiB for drawing: pictures are drawn
    when the solver's arrays are still there."""
    return plan.memory_bytes + (100 + (0 if case.plots == "none" else 105)) * 2**20


def _picture_seconds(plots: str, contact: Problem, plan: Planned) -> float:
    """Time for loading matplotlib and for each picture, on one core: four of every run, those of the plan, one of profiles; or
    the summary alone."""
    count = 4 + plan.in_words.more_pictures + (not contact.geometry.elliptic)
    return {"none": 0.0, "summary": 0.7}.get(plots, 0.5 + 0.2 * count)
