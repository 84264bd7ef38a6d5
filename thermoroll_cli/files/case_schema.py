"""The keys that a case may have and what each allows: as a JSON schema for editors, and in words for errors. The schema follows
from the model that reads cases, the words from the schema."""

from __future__ import annotations

import functools
import json
import re
from collections.abc import Sequence
from typing import Any

from thermoroll_cli.files.case_errors import KeyPath
from thermoroll_cli.files.case_model import EXCLUSIVE, Settings
from thermoroll_cli.problem.kinds import Kind, every_kind
from thermoroll_cli.problem.names import unit_of
from thermoroll_cli.problem.problem import BODIES

Entry = dict[str, Any]
"""The schema of a key or a table."""


def case_schema() -> Entry:
    """JSON schema (draft 2020-12) of a case file. Units stand in the keyword `unit` of each key that has one.

    It knows every key, type and range and which keys exclude each other; convexity and the friction limit need the
    program (`thermoroll validate`). Written so that an error is about one key: alternatives by `anyOf` would only say that
    a whole table fits none of them.
    """
    return dict(json.loads(json.dumps(_schema()), object_hook=lambda node: {k: v for k, v in node.items() if k != "allowed"}))


def known_keys(path: KeyPath) -> tuple[str, ...]:
    """Keys that the table at `path` may have, in any of its forms; () is the whole case."""
    # The schema takes a tenth of the start of a run: checking a valid case does not need it.
    return tuple(entry_at(path).get("properties", ()) if path else Settings.model_fields)


def entry_at(path: KeyPath) -> Entry:
    """The schema of the key or table at `path`; empty for one that is not known."""
    return _entry(_schema(), path)


def _entry(schema: Entry, path: KeyPath) -> Entry:
    entry = schema
    for part in path:
        entry = entry.get("items", {}) if isinstance(part, int) else entry.get("properties", {}).get(part, {})
        entry = schema["$defs"].get(_definition(entry), {}) | entry
    return entry


def _definition(entry: Entry) -> str:
    """The name of the definition that `entry` refers to."""
    return str(entry.get("$ref", "")).rpartition("/")[2]


def is_table(entry: Entry) -> bool:
    """Whether a key is a table, or a list of tables."""
    return entry.get("type") == "object" or "$ref" in entry.get("items", {})


def known_words(entry: Entry) -> tuple[str, ...]:
    """The words that a key may have."""
    words = (word for part in (entry, entry.get("then", {}), entry.get("items", {}))
             for word in (*part.get("enum", ()), part.get("const")))
    return tuple(word for word in words if isinstance(word, str))


def allowed_values(path: KeyPath) -> str:
    """The values that the key at `path` may have, in words."""
    entry = entry_at(path[:-1] if isinstance(path[-1], int) else path)
    if "allowed" in entry:
        return str(entry["allowed"])
    if entry.get("type") == "object":
        return f"a table [{'.'.join(map(str, path))}]"
    choices = ["true", "false"] if entry.get("type") == "boolean" or True in entry.get("enum", ()) else []
    if "minimum" in entry:
        number = "a whole number" if entry["type"] == "integer" else "a number"
        unit = f", in {entry['unit']}" if "unit" in entry else ""
        choices.append(f"{number} from {_short(entry['minimum'])} to {_short(entry['maximum'])}{unit}")
    choices += [f'"{word}"' for word in known_words(entry)]
    if "minimum" in entry and len(choices) == 2:
        return ", or ".join(choices)
    return " or ".join([", ".join(choices[:-1]), choices[-1]] if choices[1:] else choices)


def _short(number: float) -> str:
    """1e9, not 1e+09."""
    return re.sub(r"e([-+])0*", lambda sign: "e-" if sign[1] == "-" else "e", f"{number:g}")


@functools.cache
def _schema() -> Entry:
    """The schema, with the keyword `allowed` where words say more than types and ranges."""
    # Definitions have the names of the sections, not of the classes that read them.
    text = re.sub(r'\b([A-Z][a-z]+)Table"', r'\1"', json.dumps(Settings.model_json_schema()))
    schema: Entry = json.loads(text, object_hook=_tidied)
    schema["$schema"] = "https://json-schema.org/draft/2020-12/schema"
    schema["title"] = "thermoroll case"
    tables = schema["$defs"]
    schema["properties"]["material"] = _material(schema["properties"]["material"], tables)
    tables["Profile"]["dependentRequired"] = {"kind": ["length_mm", "drop_um"]}
    alone = {key: tables["Surface"][key] for key in ("properties", "additionalProperties")}
    for entry in tables["Surfaces"]["properties"].values():
        entry |= {"type": ["object", "array"], **alone}  # a table, or a list of tables
    schema["allOf"] = [_of_kinds([kind for kind in every_kind() if kind.base]),
                       {"if": {"not": {"required": ["friction"], "properties": {"friction": {"anyOf": [
                           {"required": [key]} for key in ("over_angle", "across", "left", "right")]}}}},
                        "then": {"properties": {"load": {"required": ["friction_coefficient"]}}}}]
    for one, two, _ in EXCLUSIVE:
        (*table, first), (*other, second) = one.split("."), two.split(".")
        if table == other:
            # Definitions of tables that both bodies have are shared.
            name = _definition(_entry(schema, tuple(table)))
            absent = {"properties": {second: _not_with(one if len(table) == 1 else first)}}
            node = tables[name].setdefault("dependentSchemas", {}).setdefault(first, {"properties": {}})
            node["properties"] |= absent["properties"]
        else:
            absent = {"properties": {other[0]: {"properties": {second: _not_with(one)}}}}
            given = {"properties": {table[0]: {"required": [first]}}, "required": [table[0]]}
            schema["allOf"].append({"if": given, "then": absent})
    return schema


def _of_kinds(kinds: Sequence[Kind]) -> Entry:
    """What a case must have that is of the first of these kinds which it asks for."""
    kind, *others = kinds
    needs = [*kind.needs, *(["rolling"] if kind.rolls else [])]
    some = {table: {"if": {"not": {"anyOf": [{"required": [key]} for key in keys[1:]]}}, "then": {"required": keys[:1]}}
            for table, keys in kind.one_of.items()}
    if kind.rolls:
        some["rolling"] = {"required": ["speed_m_s"]}
    own: Entry = {"required": needs, "properties": some} if needs else {}
    if "geometry" in needs:
        across = [{"if": {"not": {"required": [f"{body}_profile"]}}, "then": {"required": [f"{body}_radius_y_mm"]}}
                  for body in BODIES]  # fmt: skip
        own |= {"if": {"properties": {"load": {"not": {"required": ["normal_N_mm"]}}}},
                "then": {"properties": {"geometry": {"allOf": across}}}}
    if not others:
        return own
    return {"if": {"anyOf": [{"required": [table]} for table in kind.tables]}, "then": own, "else": _of_kinds(others)}


def _material(described: Entry, tables: Entry) -> Entry:
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


def _not_with(other: str) -> Entry:
    """A key that must not be there. `false` would say so, too, but validators quote this schema in their message."""
    return {"not": {"description": f"anything together with {other}"}}


def _tidied(node: Entry) -> Entry:
    """`node` as a person would write it: with the units of its keys, without titles that repeat the key, without defaults of
    whole tables, and without the null that stands for "left out" (TOML has none, a key is there or not)."""
    for key, entry in node.get("properties", {}).items():
        if unit := unit_of(key):
            entry["unit"] = unit
    if isinstance(node.get("title"), str):
        del node["title"]
    if isinstance(node.get("default"), dict | None):
        node.pop("default", None)
    choices = node.get("anyOf")
    if choices and {"type": "null"} in choices:
        rest = [choice for choice in choices if choice != {"type": "null"}]
        del node["anyOf"]
        return {**rest[0], **node} if len(rest) == 1 else {"anyOf": rest, **node}
    return node
