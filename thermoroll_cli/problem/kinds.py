"""What everything else asks of a kind of problem, and where kinds are found: a contact, assemblies of contacts, and both over
time. What is particular to a kind stands in its module of `thermoroll_cli.kinds`."""

from __future__ import annotations

import importlib
import re
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache, cached_property
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple, Protocol

from thermoroll_cli.problem.geometry import Unsolvable

MODULES = ("bearing", "wheelset", "contact")
"""Modules of `thermoroll_cli.kinds`. A case is of the first kind that asks for it."""


class Task:
    """What is solved: the base of the class of problems of each kind, with the name of the kind."""

    kind: ClassVar[str]

    if TYPE_CHECKING:

        @property
        def contact(self) -> Any:
            """The `Problem`, or what the contacts of an assembly have in common."""


class InWords(NamedTuple):
    """A plan as it is shown: `stages` (name, what happens, why), `sizes` of grids, `notes`, the `record` in JSON; and how many
    pictures there are besides those of every result."""

    stages: Sequence[tuple[str, str, str]]
    sizes: Sequence[str]
    notes: Sequence[str]
    record: Mapping[str, Any]
    more_pictures: int


class Planned(Protocol):
    """What solving takes: seconds on one core, memory, and in their order the steps that are reported (none if not known)."""

    @property
    def seconds(self) -> float: ...
    @property
    def memory_bytes(self) -> int: ...
    @property
    def steps(self) -> Sequence[Any]: ...
    @property
    def in_words(self) -> InWords: ...


def found_at(place: str) -> Any:
    """What has this name, as "files.case.Case", in the package."""
    module, _, name = place.rpartition(".")
    return getattr(importlib.import_module(f"thermoroll_cli.{module}"), name)


class At:
    """An attribute of a kind that stands at another place, which is imported when it is asked for: assemblies and histories
    would be a tenth of the start of a single contact."""

    def __init__(self, place: str) -> None:
        self.place = place

    def __get__(self, kind: Kind | None, owner: type[Kind]) -> Any:
        return self if kind is None else found_at(self.place)


@dataclass(frozen=True)
class Answer:
    """How the result of a kind is named, printed and drawn. Defaults are those of a contact.

    - `contact_name`, `contact_begins`: how its contacts are called by numbers in their records, as "{side}_{number}", and how
      such names begin;
    - `scalars`, `of_contacts`: declarations of its own numbers, and of those in the records of its contacts;
    - `one`: a contact in words; `sentence`: how a report begins; `meanings`: of facts that are no scalars of a result;
    - `shown_by`: if given, tables and pictures show those contacts alone that share this number with the most loaded one;
    - `columns`, `columns_title`: a table of all contacts by these numbers, in place of one with both sides;
    - `figures`: places of the functions that draw the whole; `report_pictures`: those of contacts that a report adds."""

    contact_name: str = ""
    contact_begins: tuple[str, ...] = ()
    scalars: Mapping[str, Any] = field(default_factory=dict)
    of_contacts: Mapping[str, Any] = field(default_factory=dict)
    one: str = "contact"
    sentence: str = ""
    meanings: Mapping[str, str] = field(default_factory=dict)
    shown_by: str = ""
    columns: tuple[str, ...] = ()
    columns_title: str = ""
    figures: Mapping[str, str] = field(default_factory=dict)
    report_pictures: tuple[str, ...] = ()

    @cached_property
    def contact_keys(self) -> tuple[str, ...]:
        """Numbers that name a contact, of its record."""
        return tuple(re.findall(r"{(\w+)}", self.contact_name))

    @cached_property
    def pictures(self) -> Mapping[str, Callable[[Any], Any]]:
        """Functions that draw the whole."""
        return {name: found_at(place) for name, place in self.figures.items()}


class Kind:
    """A kind of problem: what is asked of a case, how it is solved, and how its `answer` is shown. Defaults are those of an
    assembly about which no more is known.

    Of a case:

    - `tables`: one of them makes a case one of this kind; `needs`: those that it must have; `one_of`: keys of a table, of
      which it needs one; `rolls`: it has a rolling speed;
    - `refused`: tables and keys that it cannot have, for the reason and with what is allowed in `refusal`;
    - `follows`: tables that follow from others; `without_load`: a table beside which [load] may be left out;
    - `has_positions`: it wears over several positions;
    - `base`: False of a kind that is another one over time.

    Of its solution:

    - `solver(threads, options)`: an object whose `solve(task, report=…)` returns results, each begun from those before;
    - `warnings(task)`: those that need no solution; `facts(task)`: numbers known before, in the units of their names;
    - `plan(task)`: what solving takes (`Planned`), None if that is not known;
    - `journal(path, task, case, resume=…)`: the file in which its solver keeps steps, of a case as JSON; None: it keeps none;
    - `not_resumed`: why a run begins anew where it could be expected to go on."""

    name: str
    words: str
    tables: tuple[str, ...] = ()
    needs: tuple[str, ...] = ()
    one_of: Mapping[str, tuple[str, ...]] = {}
    rolls = True
    refused: tuple[str, ...] = ()
    refusal: tuple[str, str] = ("", "")
    follows: tuple[str, ...] = ("creepage", "force")
    without_load = ""
    has_positions = False
    base = True
    solver: Any = None
    warnings: Any = staticmethod(lambda task: ())
    facts: Any = staticmethod(lambda task: {})
    plan: Any = staticmethod(lambda task: None)
    journal: Any = None
    not_resumed = ""
    answer: Answer

    def asked_for(self, tables: Collection[str]) -> bool:
        """Whether a case with these tables is one of this kind."""
        return any(table in tables for table in self.tables)

    def task(self, settings: Any, contact: Any) -> Any:
        """The task that valid settings describe; `contact` is the problem that they are of one contact."""
        raise NotImplementedError

    def geometry(self, settings: Any) -> Any:
        """A table [geometry] that stands for those of all contacts, of a kind that has none."""
        raise NotImplementedError

    def conflicts(self, sections: Mapping[str, Any]) -> Iterator[Any]:
        """Conflicts between its own keys, and with others, in a case whose tables are valid by themselves."""
        return iter(())

    def rails(self, sections: Mapping[str, Any]) -> tuple[str, ...]:
        """The sides on which wheels stand on rails, whose friction may differ; none of other kinds."""
        return ()

    def check_one_contact(self) -> None:
        """Raises Unsolvable unless it is one contact in a steady state."""
        raise Unsolvable(f"a {self.name} has several contacts, and this takes one", self.tables[-1], "[geometry] and load")

    @property
    def without_wear(self) -> Unsolvable:
        """Why the wear of a kind is not followed (`studies.worn`)."""
        return Unsolvable(f"the wear of {self.name}s is not followed", self.tables[-1], "[geometry], or [track] and [wheelset]")

    def wheelset(self, task: Any) -> Any:
        """The wheelset of a task. Raises Unsolvable if there is none."""
        raise Unsolvable(f"{self.words} has no equivalent conicity", (*self.needs, *self.tables)[0],
                         "[track] and [wheelset] in place of it")

    def known(self, task: Any) -> tuple[Planned | None, Mapping[str, float], list[str]]:
        """Plan, facts and all warnings before solving."""
        return self.plan(task), self.facts(task), list(self.warnings(task))


@cache
def every_kind() -> tuple[Kind, ...]:
    return tuple(kind for name in MODULES for kind in found_at(f"kinds.{name}.KINDS"))


@cache
def _by_name() -> dict[str, Kind]:
    return {kind.name: kind for kind in every_kind()}


@cache
def _answers() -> tuple[Answer, ...]:
    return tuple(kind.answer for kind in every_kind())


def kind_named(name: str) -> Kind:
    """The kind with a name; "" is a contact."""
    return _by_name()[name or "contact"]


def kind_of(task: Task) -> Kind:
    """The kind of a problem."""
    return kind_named(task.kind)


def kind_in(tables: Iterable[str]) -> Kind:
    """The kind of a case that has these tables."""
    given = {*tables}
    return next(kind for kind in every_kind() if kind.asked_for(given))


def contact_name(record: Mapping[str, Any]) -> str:
    """The name of a contact of an assembly, from its record; "" of a patch of one contact."""
    return next((answer.contact_name.format_map(record) for answer in _answers()
                 if answer.contact_name and all(key in record for key in answer.contact_keys)), "")


def scalars_of_contact(name: str) -> Mapping[str, Any]:
    """Declarations of the numbers of the contact of an assembly with this name; none if no contact is called so."""
    return next((answer.of_contacts for answer in _answers() if name.startswith(answer.contact_begins)), {})
