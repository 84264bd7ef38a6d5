"""A wheelset, and a wheelset over time."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping
from typing import Any

from thermoroll_cli.kinds.contact import LOADS
from thermoroll_cli.problem.geometry import Unsolvable
from thermoroll_cli.problem.kinds import Answer, At, Kind
from thermoroll_cli.problem.names import PATCH_SCALARS, TOGETHER, WHEELSET_SCALARS


class WheelsetKind(Kind):
    name, words = "wheelset", "a wheelset"
    tables = needs = ("track", "wheelset")
    refused = ("geometry", *(f"load.{key}" for key in LOADS), "creepage", "force")
    refusal = "[wheelset], from which it follows", (
        "[track] and [wheelset] without it (wheelset.angular_velocity_rad_s or traction_N decides it), or one contact without "
        "them")
    without_load, has_positions = "wheelset", True
    solver = At("many_contacts.wheelset.wheelset_result.WheelsetSolver")
    warnings = At("many_contacts.wheelset.first_contact.wheelset_warnings")
    facts = At("many_contacts.wheelset.first_contact.facts_of")
    answer = Answer(
        contact_name="{side}_{number}", contact_begins=("left_", "right_"), scalars=WHEELSET_SCALARS | TOGETHER,
        of_contacts=PATCH_SCALARS, one="patch", sentence="A wheelset on its track", report_pictures=("traction",),
        meanings={f"rolling_radius_{side}_mm": f"at first contact, {side} wheel" for side in ("left", "right")},
        figures={name: f"plots.wheelset_figures.{name}_figure" for name in ("section", "gap", "patches", "friction")} | {
            "surface": "plots.surface_figure.surface_figure"})

    def task(self, settings: Any, contact: Any) -> Any:
        from thermoroll_cli.files.case_problem import rail_friction
        from thermoroll_cli.files.case_wheelset import wheelset_of

        return wheelset_of(settings.track, settings.wheelset, contact, rail_friction(settings))

    def geometry(self, settings: Any) -> Any:
        """The radii along rolling of a wheel and a rail. Each patch gives those across rolling."""
        from thermoroll_cli.files.case_model import GeometryTable

        radius = settings.wheelset.nominal_radius_mm
        return GeometryTable(lower_radius_x_mm=math.inf, lower_radius_y_mm=math.inf, upper_radius_x_mm=radius,
                             upper_radius_y_mm=radius)

    def conflicts(self, sections: Mapping[str, Any]) -> Iterator[Any]:
        from thermoroll_cli.files.case_wheelset_conflicts import wheelset_conflicts

        return wheelset_conflicts(sections)

    def rails(self, sections: Mapping[str, Any]) -> tuple[str, ...]:
        from thermoroll_cli.files.case_wheelset_conflicts import sides_of

        return () if sections.get("wheelset") is None else sides_of(sections["wheelset"])

    def wheelset(self, task: Any) -> Any:
        return task


class WheelsetOverTimeKind(WheelsetKind):
    name = "wheelset over time"
    base = False
    solver = At("many_contacts.history.wheelset_over_time.WheelsetHistorySolver")
    warnings = At("many_contacts.history.wheelset_over_time.warnings_over_time")
    facts = At("many_contacts.history.wheelset_over_time.facts_over_time")
    not_resumed = "a wheelset over time begins anew: its steps are not kept"

    def asked_for(self, tables: Collection[str]) -> bool:
        return "history" in tables and super().asked_for(tables)

    def task(self, settings: Any, contact: Any) -> Any:
        from thermoroll_cli.files.case_history import wheelset_over_time

        return wheelset_over_time(settings.history, super().task(settings, contact))

    def conflicts(self, sections: Mapping[str, Any]) -> Iterator[Any]:
        from thermoroll_cli.files.case_conflicts import over_time
        from thermoroll_cli.files.case_wheelset_conflicts import values_of_wheelset

        yield from super().conflicts(sections)
        yield from over_time(sections, values_of_wheelset)

    @property
    def without_wear(self) -> Unsolvable:
        return Unsolvable("the wear of a contact over time is not followed", "history", "a case without [history]")

    def wheelset(self, task: Any) -> Any:
        return task.problem


KINDS = (WheelsetOverTimeKind(), WheelsetKind())
