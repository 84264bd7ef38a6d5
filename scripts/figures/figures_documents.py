"""What is written into the documents: measured tables, what the package declares (keys of a case, fields and scalars of a
result), between `<!-- table NAME -->` and `<!-- end -->`, and the output of the tutorial's commands.

    python -m scripts.figures.figures_documents

puts what is declared into docs/, and the table of claims into the README from the numbers that were measured last
(docs/figures/numbers.json, scripts/benchmark/results.json).
"""

from __future__ import annotations

import json
import os
import pathlib
import re
import shutil
import statistics
import subprocess
import sys
import tempfile
from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from scripts.benchmark.contact import ratios
from thermoroll_cli.files.case_schema import case_schema
from thermoroll_cli.problem.names import ALL_SCALARS, FIELDS

ROOT = pathlib.Path(__file__).parents[2]
PLACE = re.compile(r"(<!-- table (\S+) (\S+) -->\n).*?(<!-- end -->)", re.DOTALL)
MINUS = re.compile(r"(?<![\w.])-(?=\d)")
"""A sign before a number, but not that of an exponent."""


def fill(folder: pathlib.Path, numbers: dict[str, Any]) -> None:
    """Write table `numbers[FIGURE][TABLE]` at each place `<!-- table FIGURE TABLE -->` in the documents of `folder`.

    The README beside the folder has places, too. Places whose table has not been measured stay as they are."""
    for path in (*sorted(folder.glob("*.md")), *folder.parent.glob("README.md")):
        text = path.read_text(encoding="utf-8")
        filled = PLACE.sub(lambda place: _filled(place, numbers), text)
        if filled != text:
            path.write_text(filled, encoding="utf-8")


def _filled(place: re.Match[str], numbers: dict[str, Any]) -> str:
    begin, figure, name, end = place.groups()
    measured = numbers.get(figure, {}).get(name)
    return place.group(0) if measured is None else f"{begin}{markdown(measured)}{end}"


def markdown(measured: dict[str, Any]) -> str:
    """A Markdown table of `measured["header"]` and `measured["rows"]`."""
    rows = [[MINUS.sub("−", cell) for cell in row] for row in measured["rows"]]
    head, *body = ("| " + " | ".join(cells) + " |\n" for cells in (measured["header"], *rows))
    return "".join([head, "|" + "---|" * len(measured["header"]) + "\n", *body])


BLOCK = re.compile(r"(```console\n)(.*?)(```)", re.DOTALL)


def run_commands(document: pathlib.Path) -> None:
    """Run the commands of all ```console blocks (lines that begin with `$ `) in one empty folder, insert their output, and copy
    the picture of the creep curve."""
    text = document.read_text(encoding="utf-8")
    with tempfile.TemporaryDirectory() as folder:
        ran = BLOCK.sub(lambda block: block[1] + _session(block[2], folder) + block[3], text)
        shutil.copy(pathlib.Path(folder) / "creep" / "sweep.png", document.parent / "figures" / "creep_curve.png")
    if ran != text:
        document.write_text(ran, encoding="utf-8")


def _session(block: str, folder: str) -> str:
    commands = [line[2:] for line in block.splitlines() if line.startswith("$ ")]
    path = os.pathsep.join([str(pathlib.Path(sys.executable).parent), os.environ.get("PATH", "")])
    environment = {**os.environ, "PATH": path, "COLUMNS": "120", "NO_COLOR": "1"}
    printed = []
    for command in commands:
        done = subprocess.run(["bash", "-c", command], cwd=folder, env=environment, stdout=subprocess.PIPE,
                              stderr=subprocess.DEVNULL, text=True, check=False)
        printed.append(f"$ {command}\n{done.stdout}")
    return "".join(printed)


Schema = Mapping[str, Any]


def declared() -> dict[str, dict[str, Any]]:
    """The three tables; a test compares them with those in the documents."""
    return {
        "keys": _table_of("key | allowed | default | meaning", _keys()),
        "fields": _table_of("field | unit | meaning", _merged((f.name, f.unit, f.meaning) for f in FIELDS.values())),
        "scalars": _table_of("scalar | meaning", _merged((s.name, s.meaning) for s in ALL_SCALARS.values())),
    }


def claims() -> dict[str, Any]:
    """The README's table beside CONTACT. Its numbers are those of verification and benchmark, rounded."""
    numbers = json.loads((ROOT / "docs" / "figures" / "numbers.json").read_text(encoding="utf-8"))
    bench = json.loads((ROOT / "scripts" / "benchmark" / "results.json").read_text(encoding="utf-8"))
    (forces,) = (row[2] for row in numbers["verification"]["table"]["rows"] if row[0].startswith("creep forces of seven"))
    beside = ratios(bench["contact"]["measured"])["128"]
    (grid,) = {row["N"] for row in beside}
    (start,) = (row["seconds"] for row in bench["processes"]["measured"] if row["name"] == "run --no-plots, N = 64")
    coarse = statistics.median(row["contact_seconds"] for row in ratios(bench["contact"]["measured"])["32"])
    equal = f"128 × 128 elements, {statistics.median(row['solve'] for row in beside):.0f} times as long"
    return _table_of(" | thermoroll | CONTACT", [
        ["creep forces, seven isothermal cases", f"within {forces.replace('e-0', 'e-')} of the friction limit of each other, "
         "about the accuracy of CONTACT's extrapolation", ""],
        [f"processor time for equal error, {len(beside)} of them", f"{grid} × {grid} elements",
         f"{equal} (process start not counted)"],
        ["a single coarse solution as a process", f"{start:.1f} s, most of it loading libraries", f"{coarse:.2f} s"],
        ["an estimated error behind most numbers",
         "yes, [coverage](docs/verification.md#coverage-of-the-error-estimates) tested", "no"],
        ["temperatures", "flash temperatures at any Péclet number, thermal expansion that acts back",
         "flash temperatures of fast bodies"],
        ["contacts over time", "single contacts, with heat; wheelsets on a given path", "single contacts, wheels on rails"],
        ["wheels on rails", "forces, roll and angular velocity found; conicity; wear",
         "forces found; switches, out-of-round wheels"],
        ["ball bearings, coatings, stresses, shakedown, fatigue", "yes", "stresses"],
    ])  # fmt: skip


def _table_of(header: str, rows: Iterable[list[str]]) -> dict[str, Any]:
    return {"header": header.split(" | "), "rows": list(rows)}


def _merged(rows: Iterable[tuple[str, ...]]) -> list[list[str]]:
    """Rows with names as code; a quantity of both bodies is one row, and `elastic_` stresses are left out."""
    kept = {name: cells for name, *cells in rows}
    kept = {name: cells for name, cells in kept.items() if name.removeprefix("elastic_") == name or name[8:] not in kept}
    merged = []
    for name, cells in kept.items():
        if name.replace("upper", "lower") in kept and "upper" in name:
            continue
        if name.replace("lower", "upper") in kept and "lower" in name:
            name, cells = name.replace("lower", "*"), [_either(cell) for cell in cells]
        merged.append([f"`{name}`", *(cell.replace("|", "\\|") for cell in cells)])
    return merged


def _either(meaning: str) -> str:
    return meaning.replace(", lower body", "").replace("the lower body", "each body")


def _keys() -> Iterator[list[str]]:
    schema = case_schema()
    shown: dict[str, str] = {}
    for name, entry in schema["properties"].items():
        shape = _resolved(entry, schema)
        if "properties" not in shape:
            yield _key(name, shape, required=False)
        else:
            yield from _table([f"[{name}]"], shape, schema, shown)


def _table(names: list[str], shape: Schema, schema: Schema, shown: dict[str, str]) -> Iterator[list[str]]:
    """The heading of a table, or of two of both bodies or sides, with its keys, then the tables inside it. `shown` has the
    first name of every shape: its keys are not repeated."""
    heading = ", ".join(f"**`{name}`**" for name in names)
    if (keys := repr(shape["properties"])) in shown:
        yield [heading, "", "", f"The keys of `{shown[keys]}`"]
        return
    shown[keys] = names[0]
    yield [heading, "", "", shape.get("description", "")]
    inner: list[tuple[str, Schema]] = []
    lists: list[tuple[str, Schema]] = []
    required = set(shape.get("required", ()))
    required |= {"youngs_modulus_GPa", "poisson_ratio"} if names == ["[material]"] else set()
    for key, entry in shape["properties"].items():
        found = _resolved(entry, schema)
        if "properties" in found:
            inner.append((key, found))
        elif "properties" in (item := _resolved(found.get("items", {}), schema)):
            lists.append((key, item))
        else:
            yield _key(key, found, required=key in required)
    for key, item in lists:
        own = {name: entry for name, entry in item["properties"].items() if entry != shape["properties"].get(name)}
        meaning = f"{item['description']} The keys of `{names[0]}`, and:"
        places = [f"[{name[:-1]}.{key}]]" for name in names]
        yield from _table(places, {**item, "properties": own, "description": meaning}, schema, shown)
    for key, found in inner:
        if "upper" in key or key == "right":
            continue
        places = [f"{name[:-1]}.{key}]" for name in names]
        both = list(dict.fromkeys(twin for place in places for twin in
                                  (place, place.replace("lower", "upper").replace("left", "right"))))
        if found["properties"].keys() == shape["properties"].keys() - {"lower", "upper"}:
            yield [", ".join(f"**`{place}`**" for place in both), "", "", "The same keys, if the bodies differ"]
        else:
            yield from _table(both, found, schema, shown)


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
    fill(ROOT / "docs", {"declared": declared(), "measured": {"claims": claims()}})
