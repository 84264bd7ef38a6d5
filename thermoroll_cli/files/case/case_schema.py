"""The JSON schema of case files, made from the model that reads them."""

from __future__ import annotations

from typing import Any

from thermoroll_cli.files.case.case_model import GRID_RANGE, Settings


def case_schema() -> dict[str, Any]:
    """JSON schema (draft 2020-12) of a case file. Units stand in the keyword `unit` of each number.

    It knows every key, type and range and which keys exclude each other; convexity and the friction limit need the
    program (`thermoroll validate`).
    """
    schema = _tidied(Settings.model_json_schema())
    schema["$schema"] = "https://json-schema.org/draft/2020-12/schema"
    schema["title"] = "thermoroll case"
    tables = schema["$defs"]
    tables["Numerics"]["not"] = {"required": ["grid", "accuracy"]}
    side = {"type": "integer", "minimum": GRID_RANGE[0], "maximum": GRID_RANGE[1]}
    grid = tables["Numerics"]["properties"]["grid"]
    grid["anyOf"] = [side, {"type": "array", "items": side, "minItems": 2, "maxItems": 2}]
    partition = tables["Thermal"]["properties"]["partition"]
    partition["anyOf"] = [{"type": "number", "minimum": 0, "maximum": 1}, {"const": "matched"}]
    for radius in tables["Geometry"]["properties"].values():
        radius["not"] = {"const": 0}
    schema["allOf"] = [
        {
            "not": {
                "properties": {"creepage": {"required": [direction]}, "force": {"required": [f"{direction}_N"]}},
                "required": ["creepage", "force"],
            }
        }
        for direction in ("longitudinal", "lateral")
    ]
    return schema


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
