"""What each command refuses: its exit code and the words of its message. Nothing is written, on standard output neither."""

from __future__ import annotations

import shlex
from pathlib import Path

import pytest

from tests.support import synthetic
from tests.support.command_line import MECHANICAL, call
from thermoroll_cli.files.result.outcome import write_result

USAGE, INVALID, INPUT_OUTPUT = 2, 3, 5
SWEEP = "sweep a.toml -o out"
TWO = f"{SWEEP} --over load.normal_N=1,2"
NO_RESULT = "a.toml is a case, not a result: solve it with `thermoroll run a.toml`"


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A case and a result of one name, also in another folder; an invalid case, a table that is none, and a file without
    content."""
    folder = tmp_path_factory.mktemp("refused")
    (folder / "other").mkdir()
    for place in (folder, folder / "other"):
        (place / "a.toml").write_text(MECHANICAL)
        write_result(place / "a.h5", synthetic.result((24, 24)))
    (folder / "bad.toml").write_text(MECHANICAL.replace("0.28", "0.6"))
    (folder / "other.csv").write_text("a,b\n1,2\n")
    (folder / "file").write_text("")
    return folder


@pytest.mark.parametrize(("command", "code", "words"), [
    ("validat", USAGE, ["'validate'"]),
    ("run", USAGE, ["CASE"]),
    ("run a.toml --set load.normal_N", USAGE, ["--set", "key=value"]),
    ("run a.toml --no-such-option", USAGE, ["--no-such-option"]),
    ("run a.toml --threads many", USAGE, ["--threads"]),
    ("run a.toml other/a.toml", USAGE, ["several cases would write a.h5"]),
    ("run --from a.toml", INPUT_OUTPUT, ["a.toml"]),
    ("run - -", USAGE, ["standard input can be read only once"]),
    ("validate - -", USAGE, ["standard input can be read only once"]),
    ("show bad.toml", INVALID, ["poisson_ratio"]),
    ("plot a.toml", USAGE, [NO_RESULT]),
    ("plot a.h5 other/a.h5 -o out", USAGE, ["several results would write", "a_*.png"]),
    ("plot a.h5 --fields presure", USAGE, ["there is no picture 'presure'"]),
    ("plot a.h5 --cut-y 70", USAGE, ["outside the domain"]),
    ("plot a.h5 --dpi 0", USAGE, ["--dpi"]),
    ("plot a.h5 --format jpg", USAGE, ["'jpg' is not one of 'png', 'svg', 'pdf'"]),
    ("plot other.csv", INPUT_OUTPUT, ["not the table of a sweep"]),
    ("export a.toml --format csv", USAGE, [NO_RESULT]),
    ("export a.h5", USAGE, ["--format"]),
    ("export a.h5 --format doc", USAGE, ["--format"]),
    ("compare a.h5 a.toml", USAGE, [NO_RESULT]),
    *((f"compare a.h5 a.h5 --rtol={value}", USAGE, ["--rtol"]) for value in ("-1", "nan", "inf", "x")),
    ("report a.toml", USAGE, [NO_RESULT]),
    ("report a.h5 -o a.pdf", USAGE, ["end its name with .html"]),
    ("report none.h5", INPUT_OUTPUT, ["no such file"]),
    (SWEEP, USAGE, ["--over"]),
    (f"{SWEEP} --over k=1 --over k=2", USAGE, ["k is swept twice"]),
    (f"{SWEEP} --over a=1:2:1000 --over b=1:2:1000", USAGE, ["1000000 points are too many"]),
    (f"{TWO} --set load.normal_N=3", USAGE, ["load.normal_N is swept with --over"]),
    (f"{TWO} --jobs 0", USAGE, ["--jobs"]),
    (f"{TWO} --points p.csv", USAGE, ["either --over KEY=VALUES or --points"]),
    (f"{TWO} --jobs 2 --threads 2", USAGE, ["one thread each"]),
    (f"{TWO} --jobs 2 --dask tcp://127.0.0.1:1", USAGE, ["the cluster decides"]),
    ("sweep absent.toml --over load.normal_N=1,2 -o out", INVALID, ["no such file"]),
    ("sweep a.toml --over load.normal_N=1,2 -o file", INPUT_OUTPUT, ["cannot write to"]),
    ("sweep a.toml --over load.normal_N=1,2 -o file/below", INPUT_OUTPUT, ["cannot write to"]),
    # All points are checked before the first is solved.
    *((f"{SWEEP} --over {over}", INVALID, [*words, "nothing was computed"]) for over, words in (
        ("creepage.longtudinal=1,2", ["--over creepage.longtudinal=1", "unknown key", 'did you mean "longitudinal"?']),
        ("load.normal_N=-1,5,-2", ["load.normal_N = -1", "load.normal_N = -2", "must be greater than 0"]),
        ("thermal.heat=0,1", ["must be true or false"]),
        ("thermal.peclet=rolling,slow", ["--over thermal.peclet=slow"]),
        ("load=1,2", ["must be a table"]),
        ("numerics.grid=16.5", ["whole number"]),
        ("force.longitudinal_N=5,50", ["--over force.longitudinal_N=50", "exceeds what friction can carry"]),
        ("geometry.upper_radius_y_mm=30,-20", ["convexity lost"]),
        ("load.normal_N=-5:-1:30", ["10 errors of 30"]))),
    *((f"table build -o t.h5 {options}", USAGE, [words]) for options, words in (
        ("--aspect 1,0.5", "must increase"), ("--aspect 0,1", "must be positive"), ("--aspect=-1", "must be positive"),
        ("--aspect x", "not a number"), ("--nodes 3,5,7", "at least 5 magnitudes"), ("--nodes 7,5,8", "must be odd"),
        ("--nodes 7", "three whole numbers"), ("--poisson 0.6", "--poisson"), ("--accuracy 1", "--accuracy"))),
])  # fmt: skip
def test_what_is_refused(folder: Path, command: str, code: int, words: list[str]) -> None:
    before = sorted(folder.rglob("*"))
    done = call(*shlex.split(command), cwd=folder)
    told = " ".join(done.stderr.split())
    assert (done.returncode, done.stdout) == (code, ""), told
    assert all(each in told for each in words) and told.count("unknown key") <= 1, told
    assert sorted(folder.rglob("*")) == before
