"""Every command and script of the README and of docs/, as printed; smaller sweeps and coarser cases make it cheap."""

from __future__ import annotations

import csv
import os
import re
import shlex
import shutil
import subprocess
import sys
from collections.abc import Iterator
from contextlib import chdir
from functools import cache
from pathlib import Path
from unittest import mock

import pytest

from tests.support.command_line import PATIENCE, call
from tests.support.documents import ROOT, page
from thermoroll_cli import Case, CaseError, CreepForceTable, solve

GRID = 12
SMALLER = (
    (r"(=[\d.]+:[\d.]+):\d+", r"\1:2"),  # two values of each key
    (r"rolling.speed_m_s=50,100,200", "rolling.speed_m_s=50,100"),
    (r" --jobs \d+", ""),
    (r"(-o (?:heavier|fig12|strength|loads|map|again|conicity|worn)\b|--resume)", r"\1 --no-plots"),
    (r"(sweep my_case\.toml|(?:run|wear) disc\.toml|run my_contact\.toml -o results)", r"\1 --no-plots"),
    (r"(plot \S+ --format svg)", r"\1 --fields pressure"),
    (r"(table(?: build)? -o \S+)", r"\1 --aspect 1 --accuracy 1e-2 --nodes 5,5,5 --checks 1"),
    (r"(aluminium\.h5 .*--semi-axes-mm) 5\.5,5\.2", r"\1 5.2,5.2"),  # the table has one ellipse
    (r"(conicity cases/manchester\.toml)(?: --amplitude \S+)?", r"\1 --amplitude 2:4:2"),
    (r"(run cases/angular_contact\.toml)", r"\1 --set bearing.control=outer"),
    (r"(run cases/rolling_start\.toml)", r"\1 --set history.steps=6"),
    (r"(run cases/dent\.toml)", r"\1 --set history.steps=4 --set numerics.grid=16"),
    (r"((?:run|sweep) cases/(?:crossing|wheel_flat)\.toml)", rf"\1 --set numerics.grid={GRID}"),
    (r"((?:run|sweep) cases/corrugation\.toml)", r"\1 --set history.steps=4"),
    (r"load\.friction_coefficient=0\.2,0\.3,0\.4", "load.friction_coefficient=0.2,0.3"),
    (r"for v in 50 100 200", "for v in 50"),
    (r"\$v", "50"),
    (r"table query (--longitudinal .*) 5\.5,5\.2", r"table query cases/creep_forces_circle.h5 \1 5.2,5.2"),
    (r"numerics.grid=\d+|numerics.accuracy=1e-3", f"numerics.grid={GRID}"),
    (r"((?:wear|run) (?:disc|cases/twin_disc_wear)\.toml)", rf"\1 --set numerics.grid={GRID} --set wear.depth_um=1"),
    (r"((?:run|sweep) my_case\.toml)", r"\1 --set numerics.accuracy=0.03"),
    (r"(run my_contact\.toml)(?!.*numerics)", rf"\1 --set numerics.grid={GRID}"),
    (r"(subsurface.fields=plane|run cases/coated_ball.toml)", r"\1 --set subsurface.layers=6"),
)
"""What is replaced in the commands: more would only take longer."""
WITH_TESTS = ("commands", "ci", "import", "measured_profiles", "record_over_time", "sweeps_and_tables")
"""Pages whose commands have a test of their own, which looks at what they write."""
LONG = ("article", "bearing", "examples", "history", "polymers", "surfaces", "track", "wheelset")
"""Other pages whose commands take seconds."""
SCRIPTS = ("wheelset",)
"""Pages with scripts that begin from a result of a contact."""


def blocks(name: str, kind: str) -> list[str]:
    found = re.findall(rf"```{kind}\n(.*?)```", page(name), re.DOTALL)
    assert found
    return found


def smaller(text: str) -> str:
    for pattern, replacement in SMALLER:
        text = re.sub(pattern, replacement, text)
    return text


@pytest.fixture(scope="module", autouse=True)
def one_table() -> Iterator[None]:
    """The table of creep forces that comes with the package is read once."""
    with mock.patch.object(CreepForceTable, "default", staticmethod(cache(CreepForceTable.default))):
        yield


@pytest.fixture
def place(tmp_path: Path) -> Path:
    """An empty folder beside the cases, which have few elements."""
    (tmp_path / "cases").mkdir()
    for path in (ROOT / "cases").iterdir():
        if path.suffix == ".toml":
            coarse = re.sub(r"(?m)^grid = .*", f"grid = {GRID}", path.read_text(encoding="utf-8"))
            (tmp_path / "cases" / path.name).write_text(coarse, encoding="utf-8")
        else:
            shutil.copy(path, tmp_path / "cases")
    return tmp_path


def shell(script: str, place: Path, *, codes: tuple[int, ...] = (0,)) -> str:
    """What bash prints. A single command of ours is called in this process, which saves the imports, and the shell gets its
    streams and its exit code."""
    commands, given = re.findall(r"\bthermoroll (.*?)(?= *(?:\d?>|[|;&#]|$))", script, re.MULTILINE), ""
    if len(commands) == 1 and "$" not in commands[0]:
        done = call(*shlex.split(commands[0]), cwd=place)
        given = (f"thermoroll() {{ printf %s {shlex.quote(done.stdout)}; printf %s {shlex.quote(done.stderr)} >&2; "
                 f"return {done.returncode}; }}\n")  # fmt: skip
    path = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
    env = {**os.environ, "PATH": path, "NO_COLOR": "1"}
    ran = subprocess.run(["bash", "-c", given + script], cwd=place, env=env, capture_output=True, text=True, timeout=PATIENCE)
    assert ran.returncode in codes, (script, ran.stdout, ran.stderr)
    return ran.stdout


def run(script: str, place: Path) -> None:
    """A block of commands one by one: by bash where they need a shell, else in this process, which saves the imports."""
    if re.search(r"^set|^case|^python", script, re.MULTILINE):
        shell(script, place)
        return
    for command in re.findall(r"^for (?:.*\n)*?done.*$|^(?:.*[\\|]\n)*.+$", script, re.MULTILINE):
        words = shlex.split(command.replace("\\\n", " "), comments=True)
        if re.search(r"[|&;>]", " ".join(words)):
            shell(command, place)
        elif words:
            assert words[0] == "thermoroll", command
            done = call(*words[1:], cwd=place)
            assert done.returncode == 0, (command, done.stderr)


def python(script: str, place: Path, **names: object) -> None:
    """A script in this process, where `names` are known already."""
    with chdir(place):
        exec(compile(script, "script.py", "exec"), {"__name__": "__main__", **names})


def session(block: str) -> Iterator[tuple[str, str]]:
    """Commands of a session with the output below them."""
    for entry in block.removeprefix("$ ").split("\n$ "):
        command, _, shown = entry.partition("\n")
        yield command, shown


@pytest.mark.slow
def test_readme_and_recipes(place: Path) -> None:
    """The README's minute is among the commands, which run as printed. It is installed already; the rest of that block runs."""
    install, minute = blocks("README", "sh")
    environment, pip, first = install.splitlines()
    assert "venv" in environment and pip == "pip install ."
    run(f"{first} --no-plots", place)
    (commands,) = (smaller(block) for block in blocks("commands", "sh"))
    assert minute.splitlines()[0] in commands and smaller(minute.splitlines()[1].split("#")[0]) in commands
    run(commands, place)
    (lines,) = blocks("README", "python")
    case = place / "my_case.toml"
    case.write_text(re.sub(r"(?m)^accuracy = .*", f"grid = {GRID}", case.read_text(encoding="utf-8")), encoding="utf-8")
    assert len([line for line in lines.splitlines() if line]) <= 5
    python(lines, place)
    assert (place / "traction.png").exists() and (place / "results" / "my_case_report.html").exists()
    for name in ("results/my_case.h5", "results/my_case_pressure.png", "results/my_case_pressure.svg", "results/my_case.xdmf",
                 "heavier/my_case.h5", "worn/twin_disc_wear_wear.csv", "again/my_case.h5"):
        assert (place / name).exists(), name
    assert (place / "case.schema.json").read_text().startswith("{")
    assert (place / "creep" / "sweep.csv").read_text().count("\n") == 1 + 2


@pytest.mark.slow
def test_scripts_and_ci(place: Path) -> None:
    """The workflow has the commands of the page, and finds a drift that is there."""
    recipe, limits, scripts = (smaller(block) for block in blocks("ci", "sh"))
    run(recipe, place)
    shell(limits, place, codes=(0, 6))
    run(scripts, place)
    assert (place / "speeds.jsonl").read_text().count("\n") == 1
    assert (place / "speeds" / "sweep.png").exists()
    (workflow,) = blocks("ci", "yaml")
    validate, again, compared = (shlex.split(line) for line in re.findall(r"- run: thermoroll (.*)", workflow))
    assert call(*validate, cwd=place).returncode == 0
    assert call(*again, "--set", "load.friction_coefficient=0.31", cwd=place).returncode == 0
    done = call(*compared, cwd=place)
    assert (done.returncode, "outside" in done.stdout) == (6, True)


def test_an_input_file_of_contact(place: Path) -> None:
    """The force that the page prints is that of the file which it shows."""
    (command,), (deck,) = blocks("import", "sh"), blocks("import", "text")
    (place / "braking.inp").write_text(deck, encoding="utf-8")
    printed = call(*shlex.split(command)[1:], cwd=place).stdout
    along, across = (float(value) for value in re.search(r"force \[(\S+), (\S+),", printed).groups())
    shown = re.search(r"(\S+) kN along and\s+(\S+) kN across", page("import")).groups()
    assert (f"{1e-3 * along:.1f}", f"{1e-3 * across:.1f}".replace("-", "−")) == shown
    assert (place / "imported" / "braking_1.h5").exists()


@pytest.mark.slow
def test_tutorial(place: Path) -> None:
    """Messages and exit codes are those shown."""
    for block in blocks("tutorial", "console"):
        for command, shown in session(block):
            if re.search(r"[|&;]", command) or not command.startswith("thermoroll"):
                printed = shell(smaller(command), place, codes=(0, 3))
                wanted = (line for line in shown.splitlines() if re.search("error|exit code|allowed", line))
                assert all(line in printed for line in wanted), printed
            else:
                run(smaller(command), place)
    assert (place / "results" / "my_contact.h5").exists() and (place / "creep" / "sweep.png").exists()
    (script,) = blocks("tutorial", "python")
    python(script.replace('"numerics.grid": 64', f'"numerics.grid": {GRID}'), place)


@pytest.mark.parametrize("name", [
    pytest.param(name, marks=pytest.mark.slow) if name in LONG else name
    for name in sorted(path.stem for path in (ROOT / "docs").glob("*.md") if path.stem not in WITH_TESTS)
    if "```sh\n" in (ROOT / "docs" / f"{name}.md").read_text(encoding="utf-8")])
def test_worked_examples(name: str, place: Path) -> None:
    """Every other page that has commands."""
    for block in blocks(name, "sh"):
        run(smaller(block).replace(" -o results", " --no-plots -o results"), place)


@pytest.mark.parametrize("name", sorted(path.stem for path in (ROOT / "docs").glob("*.md")))
def test_keys_and_options_that_are_shown_exist(name: str) -> None:
    """A part of a case may lack tables, but has no unknown key; a command in a sentence has no unknown option."""
    for shown in re.findall(r"```toml\n(.*?)```", page(name), re.DOTALL):
        try:
            Case.parse(shown)
        except CaseError as error:
            assert "unknown key" not in str(error), shown
    for command in re.findall(r"`thermoroll ([^`]*)`", page(name)):
        words = re.split(r"[\s\[\]]+", command)
        given = words[:2] if words[0] == "table" else words[:1]
        if wanted := {*re.findall(r"(?<![\w-])--[\w-]+", command)} - {"--help"}:
            called = [] if given[0].startswith("-") else given
            shown_help = call(*called, "--help").stdout
            assert all(re.search(rf"{option}\b", shown_help) for option in wanted), command


def test_every_block_is_run() -> None:
    """A block on a page, or of a kind, that no test here or named here reads would not be."""
    found = {(path.stem, kind) for path in (ROOT / "README.md", *(ROOT / "docs").glob("*.md"))
             for kind in re.findall(r"^```(\w+)$", path.read_text(encoding="utf-8"), re.MULTILINE)}
    read = set(re.findall(r'blocks\("(\w+)", "(\w+)"\)', Path(__file__).read_text(encoding="utf-8")))
    elsewhere = {("read_results", "python")}     # test_python_api.py
    read |= {(name, kind) for name, kind in found if kind in ("sh", "toml")} | {(name, "python") for name in SCRIPTS}
    # The record is what a file holds, shown beside its command.
    assert found - read - elsewhere - {("record_over_time", "text")} == set()


@pytest.mark.slow
def test_measured_profiles(place: Path) -> None:
    (commands,) = blocks("measured_profiles", "sh")
    *_, wear = smaller(commands).splitlines()
    run(smaller(commands).replace(wear, f"{wear.split('#')[0]} --set wear.distance_km=100 "
                                   "--set wheelset.wheels=right --no-plots"), place)
    assert (place / "results" / "measured_wheelset_contacts.csv").exists()
    with (place / "results" / "measured_wheelset_wear.csv").open() as file:
        assert float(list(csv.DictReader(file))[-1]["distance_km"]) == 100.0


@pytest.mark.slow
def test_a_record_over_time(place: Path) -> None:
    for block in blocks("record_over_time", "sh"):
        run(smaller(block).replace("run cases", "run --no-plots cases"), place)
    assert (place / "results" / "corrugation_history.gif").exists()


@pytest.mark.slow
def test_sweeps_and_tables(place: Path) -> None:
    (measured,) = blocks("sweeps_and_tables", "text")
    (place / "curve.csv").write_text(measured, encoding="utf-8")
    for name in ("dry.toml", "wet.toml"):
        shutil.copy(ROOT / "cases" / "wheel_rail.toml", place / name)
    for block in blocks("sweeps_and_tables", "sh"):
        run(smaller(block), place)
    assert (place / "loads" / "sweep.csv").read_text().count("\n") == 1 + 3 * 2
    found = Case.read(place / "fitted" / "vt_fra_roller_rig_fit.toml").settings.load.friction_coefficient
    assert found == pytest.approx(0.5135, abs=0.04)     # that of all points, on a finer grid
    first, table = blocks("sweeps_and_tables", "python")
    python(first, place)
    assert "CreepForceTable" in table   # runs in test_creep_table.py


@pytest.mark.slow
def test_scripts_of_the_other_pages(place: Path) -> None:
    result = solve(Case.read(place / "cases" / "table1.toml"))
    (place / "results").mkdir()
    result.save(place / "results" / "my_contact.h5")
    for name in SCRIPTS:
        for script in blocks(name, "python"):
            python(script, place, result=result, problem=result.problem)


def test_tables_of_a_case(place: Path) -> None:
    """What write_a_case.md shows of case files is valid."""
    profile, layers, relaxing, tracks, below, strength, wear, regimes = blocks("write_a_case", "toml")
    wheel = (ROOT / "cases" / "wheel_rail.toml").read_text(encoding="utf-8")
    for name, shown in (("thermal", tracks), ("subsurface", below), ("geometry", profile)):
        without = re.sub(rf"(?ms)^\[{name}\]\n.*?(?=^\[|\Z)", "", wheel) if f"\n[{name}]" in wheel else wheel
        assert Case.parse(f"{without}\n{shown}").problem
    assert Case.parse(f"{wheel}\n{below}\n{strength}\n{wear}").problem.wear is not None
    assert Case.parse(f"{wheel}\n{regimes}").problem.wear.upper.regimes == (10.4e6, 78.09e6, 200e6)
    coated = (ROOT / "cases" / "coated_ball.toml").read_text(encoding="utf-8")
    uncoated = re.sub(r"(?ms)^\[\[material\.upper\.layers\]\]\n.*?(?=^\[)", "", coated)
    assert len(Case.parse(f"{uncoated}\n{layers}").problem.upper.layers) == 1
    other = re.sub(r"(?ms)^\[material\.upper\]\n.*?(?=^\[)", "", uncoated)
    assert len(Case.parse(f"{other}\n{relaxing}").problem.upper.relaxation) == 3
    assert call("export", "--help").stdout.count("--stress-path") and "--stress-path Y,Z" in page("write_a_case")
