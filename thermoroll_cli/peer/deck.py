"""Input files of CONTACT (`.inp`) as cases: what each line says, in CONTACT's names and units (N, mm, s).

CONTACT keeps what a case leaves out from the case before it, of the same module and result element. Its user guide describes
the lines; the order here is that of its reader (commit d431cdb).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from thermoroll_cli.files.case_errors import CaseError, Finding, Span
from thermoroll_cli.tools.atomic import ReadError, read_bytes

LARGEST = 20_000_000
"""Bytes of an input file."""
DIGITS = {1: "C1 P B T N F S", 3: "P B T N F S"}
"""Names of the first control digits of each module; V L D C M Z E and X H G I A O W R follow."""
FRICTION = {0: ("FSTAT", "FKIN"), 2: ("FKIN", "FLIN1", "SABSH1", "FLIN2", "SABSH2"),
            3: ("FKIN", "FRAT1", "SABSH1", "FRAT2", "SABSH2"),
            4: ("FKIN", "FEXP1", "SABSH1", "FEXP2", "SABSH2"), 6: ("FREF", "TREF", "DFHEAT", "DTHEAT")}  # fmt: skip
MOTION = ("S", "Y", "Z", "ROLL", "YAW", "PITCH")


@dataclass(frozen=True)
class DeckCase:
    """One case: its `number` in the file, the `line` of its last control digits, the `contact` that it belongs to (module 1 or
    3, result element, contact patch), control digits by name and all values that hold for it. In module 1 only the first digit
    has its number, C1."""

    number: int
    line: int
    contact: tuple[int, int, int]
    digits: dict[str, int]
    values: dict[str, Any]

    @property
    def module(self) -> int:
        return self.contact[0]


def read_deck(path: Path) -> list[DeckCase]:
    """All cases of the input file at `path`. Raises CaseError, with the line where it cannot be read."""
    try:
        text = read_bytes(path, LARGEST, "an input file of CONTACT").decode("utf-8", errors="replace")
    except ReadError as cause:
        raise CaseError([Finding(str(cause), source=str(path))]) from None
    return list(cases_in(Lines(str(path), text.splitlines())))


class Lines:
    """Lines of a file, read as CONTACT does: words apart from `%` and what follows, with commas and `=` as blanks."""

    def __init__(self, name: str, lines: Sequence[str]) -> None:
        self.name, self.lines, self.number = name, lines, 0

    def fault(self, message: str, *, allowed: str = "") -> CaseError:
        line = self.lines[self.number - 1] if 0 < self.number <= len(self.lines) else ""
        return CaseError([Finding(message, allowed=allowed, source=self.name, line_text=line,
                                  span=Span(max(self.number, 1), 1, max(len(line), 1)))])  # fmt: skip

    def words(self, what: str) -> list[str]:
        """The words of the next line that has some."""
        while self.number < len(self.lines):
            self.number += 1
            parts = self.lines[self.number - 1].split("'")
            found: list[str] = []
            for k, part in enumerate(parts):
                if k % 2:
                    found.append(f"'{part}'")
                    continue
                bare, comment, _ = part.partition("%")
                found += bare.replace(",", " ").replace("=", " ").split()
                if comment:
                    break
            if found:
                return found
        raise self.fault(f"the file ends where {what} should follow")

    def read(self, names: str, kinds: str, what: str = "") -> dict[str, Any]:
        """The next values by their names, of kinds i (whole number), d (number), a (angle in rad, or in degrees with a "d"
        behind it) and s (text in quotes). Lower case: must be there, if need be on further lines; capitals: may follow."""
        labels, required = names.split()[: len(kinds)], sum(kind.islower() for kind in kinds)
        found: dict[str, Any] = {}
        while len(found) < required:
            for word in self.words(what or names):
                if len(found) == len(labels):
                    break
                value = _value(word, kinds[len(found)].lower())
                if value is not None:
                    found[labels[len(found)]] = value
                elif len(found) >= required:
                    break
                else:
                    raise self.fault(
                        f'"{word}" stands where {labels[len(found)]} of {what or names} should stand',
                        allowed={"i": "a whole number", "s": "text in quotes"}.get(kinds[len(found)].lower(), "a number"),
                    )
        return found

    def array(self, count: int, what: str) -> list[float]:
        """The next `count` numbers, on as many lines as they take; remarks behind the numbers of a line are skipped."""
        found: list[float] = []
        while len(found) < count:
            before = len(found)
            for word in self.words(what):
                if (value := _value(word, "a")) is None or len(found) == count:
                    break
                found.append(value)
            if len(found) == before:
                raise self.fault(f"{what}: {len(found)} of {count} numbers, and then this line", allowed="numbers")
        return found


def _value(word: str, kind: str) -> Any:
    if kind == "s":
        return word[1:-1] if len(word) > 2 and word[0] == word[-1] == "'" else None
    text = word.lower()
    degrees = kind == "a" and text.endswith("d")
    if kind == "a":
        text = text.removesuffix("d") if degrees else text.removesuffix("r")
    # Fortran writes 1d-5, and leaves the letter out: 1-5.
    text = text.replace("d", "e")
    if "e" not in text and (sign := max(text.rfind("-"), text.rfind("+"))) > 0:
        text = f"{text[:sign]}e{text[sign:]}"
    try:
        value = int(text) if kind == "i" else float(text)
    except ValueError:
        return None
    return value if kind == "i" else math.radians(value) if degrees else value if math.isfinite(value) else None


def cases_in(lines: Lines) -> Iterator[DeckCase]:
    """All cases of the lines of an input file. Raises CaseError."""
    kept: dict[tuple[int, int, int], dict[str, Any]] = {}
    number = 0
    while True:
        head = lines.read("MODULE RE CP", "iII", "the module of the next case, or 0")
        if (module := head["MODULE"]) == 0:
            return
        if module not in (1, 3):
            raise lines.fault(f"module {module} is unknown", allowed="1 (wheel on rail), 3 (one contact) or 0 (the end)")
        contact = module, head.get("RE", 0), head.get("CP", 0) if module == 3 else 0
        values = kept.setdefault(contact, {})
        while True:
            number += 1
            digits, line = _digits(lines, module), lines.number
            (_wheel_on_rail if module == 1 else _one_contact)(lines, digits, values)
            yield DeckCase(number, line, contact, digits, dict(values))
            if digits["R"] in (1, 3):
                break


def _digits(lines: Lines, module: int) -> dict[str, int]:
    found: dict[str, int] = {}
    for row in (DIGITS[module], "V L D C M Z E", "X H G I A O W R"):
        names = row.split()
        read = lines.read("FIRST SECOND", "iI" if names[0] == "V" else "i", f"the control digits {'-'.join(names)}")
        if not 0 <= read["FIRST"] < 10 ** len(names):
            raise lines.fault(f"{read['FIRST']} are no control digits of module {module}", allowed="-".join(names))
        found |= {name: read["FIRST"] // 10**k % 10 for k, name in enumerate(reversed(names))}
        if names[0] == "V":
            found["M2"] = read.get("SECOND", 1) % 10
    if found["X"]:
        lines.read("PSFLCIN", "i", "the digits of output for debugging")
    return found


def _settings(lines: Lines, digits: dict[str, int]) -> None:
    """Settings of CONTACT's solvers, which say nothing about the problem."""
    if digits["G"] != 1:
        lines.read("MAXGS MAXIN MAXNR MAXOUT EPS NPOT", "iiiidI")
    for names, kinds, of in (
        ("OMEGAH OMEGAS INISLP OMGSLP", "dddd", (2, 3)),
        ("INISLP OMGSLP", "dd", (4,)),
        ("FDECAY BETATH KDOWFB D_IFC D_LIN D_CNS D_SLP POW_S", "ddiddddd", (5,)),
    ):
        if digits["G"] in of:
            lines.read(names, kinds)


def _friction(lines: Lines, digits: dict[str, int], values: dict[str, Any], rows: int = 1) -> None:
    law, varies = digits["L"], digits["V"]
    if law not in FRICTION:
        raise lines.fault(f"L = {law} is no friction law", allowed="0, 1, 2, 3, 4 or 6")
    count = lines.read("NVF", "i")["NVF"] if varies in (1, 2) else rows
    place = {1: ("ALPHA ", "a"), 2: ("SVF ", "d")}.get(varies, ("", ""))
    names = FRICTION[law]
    values["friction"] = [
        lines.read(place[0] + " ".join(names), place[1] + "d" * len(names), "the friction law") for _ in range(count)
    ]
    values["law"] = law
    values["memory"] = lines.read("MEMDST MEM_S0", "dd") if law else {"MEMDST": 0.0, "MEM_S0": 1.0}


def _material(lines: Lines, digits: dict[str, int], values: dict[str, Any], module: int) -> None:
    if digits["C"] == 4:
        inclined = lines.read("IF_METH IF_VER NN", "iii" if module == 3 else "iiI")
        if module == 3:
            lines.array(2 * inclined["NN"], "inclinations")
    if digits["C"] == 9:
        lines.read("CFNAME", "s")
    read = lines.read("POISS1 POISS2 GG1 GG2", "dddd")
    for name, kinds, needed in (("FLXZ", "d", digits["B"] == 1), ("FG1 FG2 TC1 TC2", "dddd", digits["M"] == 1),
                                ("FLX K0_MF ALFAMF BETAMF", "dddd", digits["M"] == 2),
                                ("K0_MF ALFAMF BETAMF", "ddd", digits["M"] in (3, 5)),
                                ("GG3 LAYTHK TAU_C0 K_TAU", "dddd", digits["M"] == 4)):  # fmt: skip
        if needed:
            read |= lines.read(name, kinds)
    values["material"], values["influence"] = read, digits["C"]


def _damping_and_heat(lines: Lines, digits: dict[str, int], values: dict[str, Any]) -> None:
    if digits["M2"] >= 2:
        values["damping"] = lines.read("CDAMPN CDAMPT DFNMAX DFTMAX", "dddd")
    if digits["H"] == 3:
        values["heat"] = [lines.read("BKTEMP HEATCP LAMBDA DENS", "dddd") for _ in range(2)]
        if digits["M"] == 4:
            lines.read("BETAPL", "d")


def _one_contact(lines: Lines, digits: dict[str, int], values: dict[str, Any]) -> None:
    _settings(lines, digits)
    values["motion"] = lines.read("FN FX FY CPHI SPINXO SPINYO", "ddddDD", "FN, CKSI or FX, CETA or FY, CPHI")
    if digits["L"] != 1 and digits["V"] == 0:
        _friction(lines, digits, values)
    if digits["C"] in (2, 3, 4, 9):
        if digits["T"] in (2, 3):
            values["rolling"] = lines.read("CHI DQ VELOC FACPHI", "addD")
        _material(lines, digits, values, 3)
    _damping_and_heat(lines, digits, values)
    if digits["D"] == 2:
        kind = lines.read("IPOTCN", "i")["IPOTCN"]
        names = {-6: "MX MY AA BNEG BPOS SCALE"}.get(kind, "MX MY A B SCALE" if kind < 0 else "MX MY XL YL DX DY")
        values["area"] = {"IPOTCN": kind, **lines.read(names, "ii" + "d" * (len(names.split()) - 2))}
        if kind < 0:
            values["shape"] = {"IBASE": 1, "IPLAN": 1, "B": None}
    if digits["Z"] == 2 and values.get("area", {}).get("IPOTCN", 1) > 0:
        values["shape"] = _shape(lines, values.get("area", {}))
    if digits["L"] != 1 and digits["V"] == 3:
        _friction(lines, digits, values, values["area"]["MY"])
    if digits["E"] == 9:
        lines.array(2 * values["area"]["MX"] * values["area"]["MY"], "the extra rigid slip")
    _stresses(lines, digits)


def _shape(lines: Lines, area: dict[str, Any]) -> dict[str, Any]:
    shape: dict[str, Any] = lines.read("IBASE IPLAN", "ii")
    if shape["IBASE"] == 2:
        shape |= lines.read("NN XM RM Y1 DY1", "idddd")
        lines.array(shape["NN"], "heights")
    elif (count := {1: 6, 3: 8, 9: area.get("MX", 0) * area.get("MY", 0)}.get(shape["IBASE"])) is not None:
        shape["B"] = lines.array(count, "the undeformed distance")
    else:
        raise lines.fault(f"IBASE = {shape['IBASE']} is no shape", allowed="1, 2, 3 or 9")
    if shape["IPLAN"] == 4:
        patches = lines.read("NPATCH", "i")["NPATCH"]
        lines.array(4 * patches, "limits of the patches")
        if patches > 1:
            lines.array(patches * (patches - 1) // 2, "factors of the patches")
    elif count := {2: 6, 3: 8}.get(shape["IPLAN"], 0):
        lines.array(count, "the planform")
    return shape


def _stresses(lines: Lines, digits: dict[str, int]) -> None:
    """Points below the surface; where they lie does not matter here."""
    if digits["S"] >= 2:
        lines.read("MATFIL OUTPUT", "ii")
    while digits["S"] == 3 and (kind := lines.read("ISUBS", "i")["ISUBS"]) > 0:
        if kind == 9:
            counts = lines.read("NX NY NZ", "iii")
            for count in counts.values():
                lines.array(count, "places below the surface")
            continue
        if kind in (2, 6):
            lines.read("IXL IXINC IXH", "iii")
            lines.read("IYL IYINC IYH", "iii")
        elif kind in (3, 7):
            for count in lines.read("NX NY", "ii").values():
                lines.array(count, "elements")
        if kind in (1, 2, 3):
            lines.read("NZ ZL DZ", "idd")
        elif kind in (5, 6, 7):
            lines.array(lines.read("NZ", "i")["NZ"], "depths")
        else:
            raise lines.fault(f"ISUBS = {kind} is unknown", allowed="0, 1, 2, 3, 5, 6, 7 or 9")


def _wheel_on_rail(lines: Lines, digits: dict[str, int], values: dict[str, Any]) -> None:
    _settings(lines, digits)
    if digits["L"] != 1:
        _friction(lines, digits, values)
    if digits["C"] in (2, 3, 4):
        _material(lines, digits, values, 1)
    _damping_and_heat(lines, digits, values)
    if digits["D"] >= 2:
        values["grid"] = {"D": digits["D"], **lines.read("DX DS DQREL A_SEP D_SEP D_COMB D_TURN G_MISS", "dddaddDD")}
    roller = digits["C1"] >= 4
    if digits["Z"] in (1, 3):
        values["track"] = lines.read(
            f"GAUGHT SECOND THIRD {'NOMRAD' if roller else 'CANT'} CURV",
            "dddaD" if not roller else "ddddD",
            "the dimensions of the track",
        )
    if digits["Z"] == 3:
        values["rail"] = _profile(lines, "rail")
    if digits["Z"] in (2, 3):
        values["deviation"] = lines.read("DY DZ ROLL VY VZ VROLL", "ddadda", "the deviations of the rail")
        if digits["F"] == 3:
            values["deflection"] = lines.read("KY FY KZ FZ DYSTEP", "ddddD")
    if digits["E"] in (3, 5):
        values["wheelset"] = lines.read("FBDIST FBPOS NOMRAD YTAPE", "dddD", "the dimensions of the wheelset")
        values["wheel"] = _profile(lines, "wheel")
    if digits["E"] >= 1:
        values["position"] = lines.read(" ".join(MOTION), "dddaaa", "the position of the wheelset")
    if digits["E"] >= 2:
        kinds = ("a" if roller else "d") + "ddaa" + ("d" if digits["F"] in (1, 2) else "a")
        values["velocity"] = lines.read("VS VY VZ VROLL VYAW VPITCH", kinds, "the velocity of the wheelset")
        values.setdefault("flexible", {})
    if digits["E"] in (4, 5):
        for names in ("DX DY DZ DROLL DYAW DPITCH", "VX VY VZ VROLL VYAW VPITCH"):
            values["flexible"] = {
                **values["flexible"],
                **{f"wheel {name}": value for name, value in lines.read(names, "dddaaa", "deviations of the wheel").items()},
            }
    _stresses(lines, digits)


def _profile(lines: Lines, which: str) -> dict[str, Any]:
    found = lines.read("NAME MIRRORY SCALE SMOOTH MIRRORZ PRFOPT", "siddII", f"the file of the {which}'s profile")
    found |= {"LINE": lines.number, "ISMOOTH": 0}
    if found.get("PRFOPT", 0) >= 1:
        found["ISMOOTH"] = lines.read("ISMOOTH ZIGTHRS KINKHIG KINKLOW KINKWID", "iaaad")["ISMOOTH"]
    if found.get("PRFOPT", 0) >= 2:
        lines.read("ERRHND FMAXOMIT", "id")
    return found
