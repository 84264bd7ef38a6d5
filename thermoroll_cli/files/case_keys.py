"""The keys of a case: the tables, words and values that each allows, and the inputs of a case with their units."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Literal, get_args, get_origin

from pydantic.fields import FieldInfo

from thermoroll_cli.files.case_model import Allowed, Settings, Table, key_unit, si_unit


def tables_in(field: FieldInfo) -> tuple[type[Table], ...]:
    """The models of a key that is a table, or a list of tables; none for any other key."""
    return tuple(dict.fromkeys(_leaves(field.annotation, lambda kind: isinstance(kind, type) and issubclass(kind, Table))))


def table_at(path: tuple[str | int, ...]) -> tuple[type[Table], ...]:
    """The models of the table at `path`, which is () for the whole case; none where there is no table."""
    found: tuple[type[Table], ...] = (Settings,)
    for part in path:
        if isinstance(part, str):
            fields = (table.model_fields.get(part) for table in found)
            found = tuple(inner for field in fields if field is not None for inner in tables_in(field))
    return found


def known_keys(path: tuple[str | int, ...]) -> tuple[str, ...]:
    """Keys that the table at `path` may have, in any of its forms."""
    return tuple(dict.fromkeys(key for table in table_at(path) for key in table.model_fields))


def takes_numbers(field: FieldInfo) -> bool:
    """Whether a key may be a number, or true or false."""
    return any(_leaves(field.annotation, lambda kind: kind in (bool, int, float)))


def known_words(field: FieldInfo) -> tuple[str, ...]:
    """The words that a key may have."""
    literals = _leaves(field.annotation, lambda kind: get_origin(kind) is Literal)
    return tuple(word for literal in literals for word in get_args(literal) if isinstance(word, str))


def _leaves(annotation: Any, wanted: Any) -> Iterator[Any]:
    """The parts of a type, however deep, for which `wanted` holds."""
    if wanted(annotation):
        yield annotation
        return
    for part in get_args(annotation):
        yield from _leaves(part, wanted)


def _metadata(field: FieldInfo) -> list[Any]:
    """Annotations of a field and of the alternatives of its type."""
    inner = [item for part in get_args(field.annotation) for item in getattr(part, "__metadata__", ())]
    # Limits in Annotated[float, Field(ge=0)] stand in a field of their own.
    return [*field.metadata, *(note for item in inner for note in (item.metadata if isinstance(item, FieldInfo) else (item,)))]


def allowed_values(field: FieldInfo) -> str:
    """The values a key may have, in words."""
    notes = _metadata(field)
    stated = next((note.words for note in notes if isinstance(note, Allowed)), "")
    if stated:
        return stated
    if tables_in(field):
        return "a table"
    kinds = list(_leaves(field.annotation, lambda kind: kind in (bool, int, float)))
    choices = ["true", "false"] if bool in kinds else []
    limits = {name: getattr(note, name) for note in notes for name in ("ge", "le") if hasattr(note, name)}
    if limits:
        number = "a whole number" if int in kinds else "a number"
        unit = key_unit(field)
        choices.append(f"{number} from {_short(limits['ge'])} to {_short(limits['le'])}{f', in {unit}' if unit else ''}")
    choices += [f'"{word}"' for word in known_words(field)]
    if limits and len(choices) == 2:
        return ", or ".join(choices)
    return " or ".join([", ".join(choices[:-1]), choices[-1]] if choices[1:] else choices)


def _short(number: float) -> str:
    """1e9, not 1e+09."""
    return re.sub(r"e([-+])0*", lambda sign: "e-" if sign[1] == "-" else "e", f"{number:g}")


@dataclass(frozen=True)
class Input:
    """A key with its `value` in the unit of the key, and in SI: `si` is None for what is no number, `unit` empty for what
    has none."""

    key: str
    value: Any
    si: float | None
    unit: str

    @property
    def shown(self) -> str:
        """The value in the unit of the key, as text."""
        return _shown(self.value)

    @property
    def shown_si(self) -> str:
        """The value in SI units, where those say more than the number alone."""
        return f"{self.si:.6g} {self.unit}" if self.si is not None and self.unit else ""


def inputs(table: Table, prefix: str = "") -> Iterator[Input]:
    """All keys of a case that have a value, in the order of the tables."""
    for name, field in type(table).model_fields.items():
        value, key = getattr(table, name), prefix + name
        if isinstance(value, Table):
            yield from inputs(value, f"{key}.")
        elif isinstance(value, list) and value and isinstance(value[0], Table):
            for number, item in enumerate(value):
                yield from inputs(item, f"{key}.{number}.")
        elif value is not None and value != "":
            number = isinstance(value, int | float) and not isinstance(value, bool)
            yield Input(key, value, float(table.si(name)) if number else None, si_unit(field)[0] if number else "")


def _shown(value: Any) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, list | tuple):
        return f"{len(value)} values" if len(value) > 2 else "×".join(map(_shown, value))
    return f"{value:.6g}" if isinstance(value, float) else str(value)
