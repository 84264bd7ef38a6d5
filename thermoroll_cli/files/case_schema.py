"""The JSON schema of case files, made from the model that reads them."""

from __future__ import annotations

import json
import re
from typing import Any

from thermoroll_cli.files.case_keys import table_at
from thermoroll_cli.files.case_model import BODIES, EXCLUSIVE, GRID_RANGE, RADIUS_RANGE, Settings


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
    side = {"type": "integer", "minimum": GRID_RANGE[0], "maximum": GRID_RANGE[1]}
    _instead(tables["Numerics"]["properties"]["grid"], side, type=["integer", "array"], items=side, minItems=2, maxItems=2)
    share = {"type": ["number", "string"], "minimum": 0, "maximum": 1}
    _instead(tables["Thermal"]["properties"]["partition"], share, **{"if": {"type": "string"}, "then": {"enum": ["matched"]}})
    _instead(tables["Thermal"]["properties"]["deformation"], {"enum": [True, False, "always"]})
    geometry = tables["Geometry"]
    for key, radius in geometry["properties"].items():
        if not key.endswith("_mm"):
            continue
        # JSON has no infinity: editors that check TOML by this schema hand inf on as null.
        smallest, largest = RADIUS_RANGE
        radius |= {"type": ["number", "null"], "minimum": -largest}
        radius["not"] = {"type": "number", "exclusiveMinimum": -smallest, "exclusiveMaximum": smallest}
    geometry["allOf"] = [{"if": {"not": {"required": [f"{body}_profile"]}}, "then": {"required": [f"{body}_radius_y_mm"]}}
                         for body in BODIES]  # fmt: skip
    tables["Profile"]["dependentRequired"] = {"kind": ["length_mm", "drop_um"]}
    schema["allOf"] = []
    for pair in EXCLUSIVE:
        (*table, first), (*other, second) = pair.first, pair.second
        if table == other:
            # Definitions of tables that both bodies have are shared.
            name = table_at(tuple(table))[0].__name__.removesuffix("Table")
            absent = {"properties": {second: _not_with(".".join(pair.first) if len(table) == 1 else first)}}
            node = tables[name].setdefault("dependentSchemas", {}).setdefault(first, {"properties": {}})
            node["properties"] |= absent["properties"]
        else:
            absent = {"properties": {other[0]: {"properties": {second: _not_with(".".join(pair.first))}}}}
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


def _instead(key: dict[str, Any], first: dict[str, Any], **more: Any) -> None:
    """Replace the alternatives of `key` by keywords that each concern one type only."""
    key.pop("anyOf", None)
    key |= first | more


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
