"""A contact, and a contact over time."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import replace
from typing import Any

from thermoroll_cli.problem.geometry import Unsolvable
from thermoroll_cli.problem.kinds import Answer, At, Kind, Planned

LOADS = ("normal_N", "normal_N_mm", "hertz_pressure_MPa", "approach_um", "vertical_N")
"""Keys of which a contact has one."""


class ContactKind(Kind):
    name, words = "contact", "a single contact"
    needs = ("geometry",)
    one_of: Mapping[str, tuple[str, ...]] = {"load": LOADS}
    follows = ()
    solver = At("one_contact.refinement.solve.ContactSolver")
    plan = At("one_contact.refinement.plan.make_plan")
    answer = Answer()

    def asked_for(self, tables: Collection[str]) -> bool:
        return True

    def task(self, settings: Any, contact: Any) -> Any:
        return contact

    def check_one_contact(self) -> None:
        pass

    def warnings(self, task: Any) -> Iterable[str]:
        from thermoroll_cli.one_contact.refinement.expected_heat import expected_temperature_warning
        from thermoroll_cli.one_contact.steady_state.derived import derived_of
        from thermoroll_cli.one_contact.steady_state.doubts import warnings_before

        derived = derived_of(task)
        return *warnings_before(derived), *expected_temperature_warning(derived)

    def known(self, task: Any) -> tuple[Planned | None, Mapping[str, float], list[str]]:
        """Those of the plan, which changes the domain of some problems."""
        from thermoroll_cli.one_contact.refinement.expected_heat import expected_temperature_warning

        plan = self.plan(task)
        return plan, plan.facts, [*plan.warnings, *expected_temperature_warning(plan.derived)]


class ContactOverTimeKind(ContactKind):
    name = "contact over time"
    base = False
    solver = At("many_contacts.history.solve.HistorySolver")
    warnings = At("many_contacts.history.history_plan.warnings_of")
    plan = At("many_contacts.history.history_plan.plan_of")
    journal = At("many_contacts.history.kept_steps.journal_of")

    def asked_for(self, tables: Collection[str]) -> bool:
        return "history" in tables

    def task(self, settings: Any, contact: Any) -> Any:
        from thermoroll_cli.files.case_history import contact_over_time
        from thermoroll_cli.files.case_surface import given_surfaces, surface_of

        history = contact_over_time(settings.history, contact)
        found = {given.body: surface_of(given.parts, given.body, given.radius, line=contact.line)
                 for given in given_surfaces(dict(settings))}
        return replace(history, surfaces=(found.get("lower"), found.get("upper")))

    def check_one_contact(self) -> None:
        raise Unsolvable("a contact over time has many states, and this takes one", "history", "a case without [history]")

    def conflicts(self, sections: Mapping[str, Any]) -> Iterator[Any]:
        from thermoroll_cli.files.case_conflicts import over_time
        from thermoroll_cli.files.case_history import values_of_contact

        return over_time(sections, values_of_contact)

    @property
    def without_wear(self) -> Unsolvable:
        return Unsolvable("the wear of a contact over time is not followed", "history", "a case without [history]")

    def known(self, task: Any) -> tuple[Planned | None, Mapping[str, float], list[str]]:
        """Facts are those at the largest load."""
        plan = self.plan(task)
        facts = ContactKind().known(task.largest)[1]
        return plan, {name: value for name, value in facts.items() if value == value}, [*self.warnings(task)]


KINDS = (ContactOverTimeKind(), ContactKind())
