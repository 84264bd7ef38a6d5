"""Forces in the output of CONTACT (`.out`, `.ref_out`)."""

from __future__ import annotations

import re
from pathlib import Path

from thermoroll_cli.tools.atomic import read_bytes

LARGEST = 1_000_000_000
NUMBER = re.compile(r"-?\d[\d.]*(?:[eE][-+]?\d+)?|-?\.\d+")
ON_RAIL, OF_CONTACT = ("TOTAL FORCES ON RAIL", "TOTAL FORCES ON ROLLER"), "TOTAL FORCES, TORSIONAL MOMENT"


def output_beside(deck: Path) -> Path | None:
    """The output of the input file `deck` where it lies beside it."""
    return next((path for ending in (".out", ".ref_out") if (path := deck.with_suffix(ending)).is_file()), None)


def reference_forces(path: Path) -> dict[int, list[float]]:
    """[x, y, z] in N for each case in the output at `path`, in CONTACT's axes: on the rail, or on body 1 with the normal force
    as z. Cases without forces are left out. Result elements are numbered by themselves, and count as cases in turn here. Raises
    OSError."""
    found: dict[int, list[float]] = {}
    lines = read_bytes(path, LARGEST, "output of CONTACT").decode("utf-8", errors="replace").splitlines()
    case = 0
    for number, line in enumerate(lines):
        if head := re.match(r" Case +(\d+)(,? (?:result|for contact).*)?\s*$", line):
            case = case + 1 if head[2] else int(head[1])
        elif case and case not in found and (line.strip().startswith((*ON_RAIL, OF_CONTACT))):
            numbers = [float(word) for word in NUMBER.findall("".join(lines[number + 2 : number + 3]))]
            if len(numbers) >= 3:
                found[case] = numbers[:3] if line.strip().startswith(ON_RAIL) else [*numbers[1:3], numbers[0]]
    return found
