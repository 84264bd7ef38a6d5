"""`thermoroll show`: what a case means and what solving it would take."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import typer

from thermoroll_cli.cli import options, streams

if TYPE_CHECKING:
    from thermoroll_cli.files.case.case import Case
    from thermoroll_cli.refinement.plan import Plan

UNITS = {
    "youngs_modulus": "Pa",
    "conductivity": "W/(m K)",
    "expansion": "1/K",
    "diffusivity": "m²/s",
    "lower_radius_x": "m",
    "lower_radius_y": "m",
    "upper_radius_x": "m",
    "upper_radius_y": "m",
    "normal_force": "N",
    "speed": "m/s",
    "spin": "rad/m",
    "force_x": "N",
    "force_y": "N",
    "bulk_lower": "K",
    "bulk_upper": "K",
    "friction_slope": "1/K",
}
"""Units of the inputs that are not plain numbers."""


def show(
    case: options.OneCase,
    settings: options.Settings = None,
    as_json: options.AsJson = False,
    verbose: options.Verbose = False,
) -> None:
    """Show what a case means and what would run.

    Inputs in SI units, Hertz and Péclet numbers, saturation creepage, and the plan: stages that run, stages that are
    skipped and why, expected memory and time.
    """
    from thermoroll_cli.files.case.case import Case, CaseError
    from thermoroll_cli.refinement.plan import make_plan

    try:
        read = Case.read(case, options.parse_overrides(settings))
    except CaseError as cause:
        raise typer.Exit(options.tell_invalid([cause])) from None
    plan = make_plan(read.problem)
    if as_json:
        streams.write_json(_record(read, plan))
        return
    for line in _lines(read, plan):
        streams.write(line)


def _record(case: Case, plan: Plan) -> dict[str, Any]:
    return {
        "name": case.name,
        "inputs": dataclasses.asdict(case.problem),
        **plan.facts,
        "run": plan.run,
        "skipped": plan.skipped,
        "warnings": plan.warnings,
        "grid": plan.grid,
        "memory_bytes": plan.memory_bytes,
        "seconds": plan.seconds,
    }


def _lines(case: Case, plan: Plan) -> Iterator[str]:
    from thermoroll_cli.cli.result_table import align, number

    problem = case.problem
    yield case.name + (f" ({problem.title})" if problem.title else "")
    yield "inputs in SI units"
    yield from align(list(_inputs(problem)))
    yield "known before solving"
    yield from align([(name, number(value)) for name, value in plan.facts.items()])
    yield "plan"
    steps = [(name, "runs") for name in plan.run] + [(name, f"skipped: {why}") for name, why in plan.skipped.items()]
    yield from align(steps)
    accuracy = problem.numerics.accuracy
    upto = f" at most, until the scalars are good to {accuracy:g}" if accuracy is not None else ""
    yield f"  grid {plan.grid[0]}×{plan.grid[1]}{upto}"
    yield f"  about {plan.memory_bytes / 2**20:.0f} MiB and {plan.seconds:.2g} s"
    for warning in plan.warnings:
        yield f"  warning: {warning}"


def _inputs(part: Any, prefix: str = "") -> Iterator[tuple[str, str, str]]:
    for field in dataclasses.fields(part):
        value = getattr(part, field.name)
        if dataclasses.is_dataclass(value):
            yield from _inputs(value, f"{prefix}{field.name}.")
        elif value is not None and value != "":
            shown = f"{value:.6g}" if isinstance(value, float) else str(value)
            yield prefix + field.name, shown, UNITS.get(field.name, "")
