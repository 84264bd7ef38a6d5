"""The keys that a case may have and what each allows: in words for errors, and as a JSON schema for editors. Both follow from
the model that reads cases."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from typing import Any, Literal, get_args, get_origin

from pydantic.fields import FieldInfo

from thermoroll_cli.files.case_model import EXCLUSIVE, Allowed, Settings, Table, key_unit
from thermoroll_cli.problem.problem import BODIES


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


def case_schema() -> dict[str, Any]:
    """JSON schema (draft 2020-12) of a case file. Units stand in the keyword `unit` of each number.

    It knows every key, type and range and which keys exclude each other; convexity and the friction limit need the
    program (`thermoroll validate`). Written so that an error is about one key: alternatives by `anyOf` would only say that
    a whole table fits none of them.
    """
    # Definitions have the names of the sections, not of the classes that read them.
    text = json.dumps(Settings.model_json_schema())
    schema = _tidied(json.loads(re.sub(r'\b([A-Z][a-z]+)Table"', r'\1"', text)))
    schema["$schema"] = "https://json-schema.org/draft/2020-12/schema"
    schema["title"] = "thermoroll case"
    tables = schema["$defs"]
    schema["properties"]["material"] = _material(schema["properties"]["material"], tables)
    geometry = tables["Geometry"]
    geometry["allOf"] = [{"if": {"not": {"required": [f"{body}_profile"]}}, "then": {"required": [f"{body}_radius_y_mm"]}}
                         for body in BODIES]  # fmt: skip
    tables["Profile"]["dependentRequired"] = {"kind": ["length_mm", "drop_um"]}
    schema["allOf"] = []
    for one, two, _ in EXCLUSIVE:
        (*table, first), (*other, second) = one.split("."), two.split(".")
        if table == other:
            # Definitions of tables that both bodies have are shared.
            name = table_at(tuple(table))[0].__name__.removesuffix("Table")
            absent = {"properties": {second: _not_with(one if len(table) == 1 else first)}}
            node = tables[name].setdefault("dependentSchemas", {}).setdefault(first, {"properties": {}})
            node["properties"] |= absent["properties"]
        else:
            absent = {"properties": {other[0]: {"properties": {second: _not_with(one)}}}}
            given = {"properties": {table[0]: {"required": [first]}}, "required": [table[0]]}
            schema["allOf"].append({"if": given, "then": absent})
    return schema


def _material(described: dict[str, Any], tables: dict[str, Any]) -> dict[str, Any]:
    """One table with the keys of both forms, of which either goes alone."""
    one, two = tables["Material"], tables.pop("TwoMaterials")
    constants = dict.fromkeys(one["properties"], _not_with("[material.lower] and [material.upper]"))
    return {
        "description": described["description"],
        "type": "object",
        "properties": one["properties"] | two["properties"],
        "additionalProperties": False,
        "if": {"anyOf": [{"required": [body]} for body in two["properties"]]},
        "then": {"required": two["required"], "properties": constants},
        "else": {"required": one["required"]},
    }


def _not_with(other: str) -> dict[str, Any]:
    """A key that must not be there. `false` would say so, too, but validators quote this schema in their message."""
    return {"not": {"description": f"anything together with {other}"}}


def _tidied(node: Any) -> Any:
    """`node` as a person would write it: without titles that repeat the key, without defaults of whole tables, and
    without the null that stands for "left out" (TOML has none, a key is there or not)."""
    if isinstance(node, list):
        return [_tidied(item) for item in node]
    if not isinstance(node, dict):
        return node
    dropped = {"title"} if isinstance(node.get("title"), str) else set()
    dropped |= {"default"} if isinstance(node.get("default"), dict | None) else set()
    node = {key: _tidied(value) for key, value in node.items() if key not in dropped}
    choices = node.get("anyOf")
    if choices and {"type": "null"} in choices:
        rest = [choice for choice in choices if choice != {"type": "null"}]
        del node["anyOf"]
        return {**rest[0], **node} if len(rest) == 1 else {"anyOf": rest, **node}
    return node
