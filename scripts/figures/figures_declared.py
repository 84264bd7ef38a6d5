"""Tables of what the package declares: keys of a case (from the schema), fields and scalars of a result (problem/names.py).

    python -m scripts.figures.figures_declared

puts them into docs/."""

from __future__ import annotations

import pathlib
from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from scripts.figures.figures_tables import fill
from thermoroll_cli.files.case_schema import case_schema
from thermoroll_cli.problem.names import FIELDS, HERTZ_SCALARS, SCALARS, SUBSURFACE_SCALARS, Scalar

Schema = Mapping[str, Any]


def declared() -> dict[str, dict[str, Any]]:
    """The three tables; a test compares them with those in the documents."""
    return {
        "keys": _table_of("key | allowed | default | meaning", _keys()),
        "fields": _table_of("field | unit | meaning", _merged((f.name, f.unit, f.meaning) for f in FIELDS.values())),
        "scalars": _table_of("scalar | meaning", _merged(map(_scalar, _scalars()))),
    }


def _table_of(header: str, rows: Iterable[list[str]]) -> dict[str, Any]:
    return {"header": header.split(" | "), "rows": list(rows)}


def _scalars() -> Iterator[Scalar]:
    yield from SCALARS.values()
    yield from HERTZ_SCALARS.values()
    yield from SUBSURFACE_SCALARS.values()


def _scalar(scalar: Scalar) -> tuple[str, str]:
    return scalar.name, scalar.meaning


def _merged(rows: Iterable[tuple[str, ...]]) -> list[list[str]]:
    """Rows with names as code; a quantity of both bodies is one row, and `elastic_` stresses are left out."""
    kept = {name: cells for name, *cells in rows if not name.startswith("elastic_")}
    merged = []
    for name, cells in kept.items():
        if name.replace("upper", "lower") in kept and "upper" in name:
            continue
        if name.replace("lower", "upper") in kept and "lower" in name:
            name, cells = name.replace("lower", "*"), [_either(cell) for cell in cells]
        merged.append([f"`{name}`", *cells])
    return merged


def _either(meaning: str) -> str:
    return meaning.replace(", lower body", ", each body").replace("the lower body", "each body")


def _keys() -> Iterator[list[str]]:
    schema = case_schema()
    for name, entry in schema["properties"].items():
        shape = _resolved(entry, schema)
        if "properties" not in shape:
            yield _key(name, shape, required=False)
        else:
            yield from _table(f"[{name}]", shape, schema)


def _table(name: str, shape: Schema, schema: Schema) -> Iterator[list[str]]:
    """The heading of a table with its keys, then the tables inside it, of which those of both bodies are one."""
    yield [f"**`{name}`**", "", "", shape.get("description", "")]
    inner: list[tuple[str, Schema]] = []
    lists: list[tuple[str, Schema]] = []
    required = set(shape.get("required", ())) | ({"youngs_modulus_GPa", "poisson_ratio"} if name == "[material]" else set())
    for key, entry in shape["properties"].items():
        found = _resolved(entry, schema)
        if "properties" in found:
            inner.append((key, found))
        elif "properties" in (item := _resolved(found.get("items", {}), schema)):
            lists.append((key, item))
        else:
            yield _key(key, found, required=key in required)
    for key, item in lists:
        yield from _table(f"[{name[:-1]}.{key}]]", item, schema)
    for key, found in inner:
        if "upper" in key:
            continue
        place = f"{name[:-1]}.{key}]"
        both = f"{place}`**, **`{place.replace('lower', 'upper')}"
        if found["properties"].keys() == shape["properties"].keys() - {"lower", "upper"}:
            yield [f"**`{both}`**", "", "", "the same keys, where the bodies differ"]
        else:
            yield from _table(both, found, schema)


def _resolved(entry: Schema, schema: Schema) -> Schema:
    reference = entry.get("$ref", "").rpartition("/")[2]
    return schema["$defs"][reference] if reference else entry


def _key(name: str, shape: Schema, *, required: bool) -> list[str]:
    default = "required" if required else _word(shape["default"]) if "default" in shape else ""
    return [f"`{name}`", _allowed(shape), default, shape.get("description", "").replace("|", "\\|")]


def _allowed(shape: Schema) -> str:
    kind = shape.get("type")
    words = shape.get("enum", [shape["const"]] if "const" in shape else [])
    words += shape.get("then", {}).get("enum", []) + shape.get("items", {}).get("enum", [])
    text = ", ".join(map(_word, words))
    if "maximum" in shape:
        span = f"{shape['minimum']:g} … {shape['maximum']:g}"
        return f"{span}, {text}" if text else span
    if "minimum" in shape:
        return "not 0; `inf` is flat"
    return text or {"boolean": "true, false", "string": "text", "array": "array"}.get(kind if isinstance(kind, str) else "", "")


def _word(value: Any) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, list):
        return "both" if len(value) == 2 else str(value)
    return f'"{value}"' if isinstance(value, str) else f"{value:g}"


if __name__ == "__main__":
    fill(pathlib.Path(__file__).parents[2] / "docs", {"declared": declared()})
