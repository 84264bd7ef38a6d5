"""Forces in the output of CONTACT (`.out`, `.ref_out`)."""

from __future__ import annotations

import re
from pathlib import Path
from typing import NamedTuple

from thermoroll_cli.tools.atomic import read_bytes

LARGEST = 1_000_000_000
NUMBER = re.compile(r"-?\d[\d.]*(?:[eE][-+]?\d+)?|-?\.\d+")
ON_RAIL, OF_CONTACT = ("TOTAL FORCES ON RAIL", "TOTAL FORCES ON ROLLER"), "TOTAL FORCES, TORSIONAL MOMENT"


def output_beside(deck: Path) -> Path | None:
    """The output of the input file `deck` where it lies beside it."""
    return next((path for ending in (".out", ".ref_out") if (path := deck.with_suffix(ending)).is_file()), None)


class Forces(NamedTuple):
    """Forces [x, y, z] in N of a case in CONTACT's axes: on the rail, or on body 1 with the normal force as z; and the sums
    over `patches` of those along, across and normal to each."""

    whole: list[float]
    patches: list[float]


def reference_forces(path: Path) -> dict[int, Forces]:
    """Forces of each case in the output at `path`. Cases without forces are left out. Result elements are numbered by
    themselves, and count as cases in turn here. Raises OSError."""
    found: dict[int, Forces] = {}
    lines = read_bytes(path, LARGEST, "output of CONTACT").decode("utf-8", errors="replace").splitlines()
    case = 0
    for number, line in enumerate(lines):
        if head := re.match(r" Case +(\d+)(,? (?:result|for contact).*)?\s*$", line):
            case = case + 1 if head[2] else int(head[1])
        elif case and line.strip().startswith((*ON_RAIL, OF_CONTACT)):
            numbers = [float(word) for word in NUMBER.findall("".join(lines[number + 2 : number + 3]))]
            if len(numbers) < 3:
                continue
            on_rail, of_contact = line.strip().startswith(ON_RAIL), [*numbers[1:3], numbers[0]]
            before = found.get(case) or Forces(numbers[:3] if on_rail else of_contact, [0.0, 0.0, 0.0])
            if not on_rail:
                sums = [sum(both) for both in zip(before.patches, of_contact, strict=True)]
                before = before._replace(patches=sums)
            found[case] = before
    return found
