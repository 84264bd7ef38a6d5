"""Sweeps when something goes wrong: points that fail, files that are damaged, folders that are taken or full."""

from __future__ import annotations

import csv
import errno
import json
import multiprocessing
import os
import random
import shutil
import threading
import time
from collections import Counter
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from tests.support.command_line import MECHANICAL, THERMAL, call, limited
from tests.support.sampling import sampled
from tests.support.tasks import DeadlyTask, SlowDiskTask
from thermoroll_cli.cli import streams
from thermoroll_cli.files.result.outcome import read_result
from thermoroll_cli.one_contact.refinement.solve import ContactSolver
from thermoroll_cli.studies.sweeps.points import Base, Points, parse_axes
from thermoroll_cli.studies.sweeps.sweep import JOURNAL_FORMAT, JOURNAL_NAME, Batch, Pending
from thermoroll_cli.tools import atomic
from thermoroll_cli.tools.atomic import WriteError
from thermoroll_cli.tools.journal import Journal, JournalError
from thermoroll_cli.tools.runner import Workers, run

CASE = MECHANICAL.replace("grid = 16", "grid = 8")
OVER = ("--over", "creepage.longitudinal=0.001:0.002:3", "--no-plots")


@pytest.fixture
def case(tmp_path: Path) -> Path:
    path = tmp_path / "spheres.toml"
    path.write_text(CASE)
    return path


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    path = tmp_path / "out"
    path.mkdir()
    return path


def rows(folder: Path) -> list[dict[str, str]]:
    return list(csv.DictReader((folder / "sweep.csv").read_text().splitlines()))


# --- points that fail ----------------------------------------------------------------------------------------------


def test_a_point_without_a_steady_state_is_a_row(tmp_path: Path, folder: Path) -> None:
    hot = tmp_path / "hot.toml"
    hot.write_text(THERMAL + '[thermal]\npeclet = "stationary"\n')
    options = ("--over", "rolling.speed_m_s=1e5,50", "--set", "numerics.grid=8", "--json", "--no-plots", "-o", folder)
    done = call("sweep", hot, *options)
    assert done.returncode == 4
    records = [json.loads(line) for line in done.stdout.splitlines()]
    assert [record["status"] for record in records] == ["not_converged", "converged"]
    assert [row["status"] for row in rows(folder)] == ["not_converged", "converged"]
    assert rows(folder)[0]["reason"] == records[0]["reason"] != ""
    assert f"hot_0001 did not converge: {records[0]['reason']}" in done.stderr
    assert done.stderr.count(records[0]["reason"]) == 1
    assert not read_result(folder / "hot_0001.h5").converged
    # The scalars belong to the speed of the point: T_γ is Q_F/V.
    assert float(rows(folder)[0]["Q_F_W"]) / float(rows(folder)[0]["T_gamma_N"]) == pytest.approx(1e5, rel=1e-9)
    # Trying again would end the same way.
    again = call("sweep", hot, *options, "--resume")
    assert (again.returncode, again.stdout) == (4, done.stdout)
    assert "2 of 2 points are finished already" in again.stderr


@pytest.mark.parametrize(
    ("cause", "reason"), [(ZeroDivisionError("by zero"), "ZeroDivisionError: by zero"), (MemoryError(), "not enough memory")]
)
def test_an_exception_is_a_row_and_is_tried_again(
    cause: Exception, reason: str, case: Path, folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    good = ContactSolver.solve

    def bad_at_one(self: ContactSolver, problem: Any, **options: Any) -> Any:
        if problem.motion.creepage_x == 0.0015:
            raise cause
        return good(self, problem, **options)

    with monkeypatch.context() as patch:
        patch.setattr(ContactSolver, "solve", bad_at_one)
        done = call("sweep", case, *OVER, "-o", folder)
    assert done.returncode == 4
    assert "2 of 3 points converged" in done.stdout
    assert f"spheres_0002 did not converge: {reason}" in done.stderr
    assert [row["reason"] for row in rows(folder)] == ["", reason, ""]
    assert (rows(folder)[1]["status"], rows(folder)[1]["Q_F_W"], rows(folder)[1]["file"]) == ("not_converged", "", "")
    assert not (folder / "spheres_0002.h5").exists()
    assert call("sweep", case, *OVER, "-o", folder, "--resume").returncode == 0
    assert [row["status"] for row in rows(folder)] == ["converged"] * 3


def test_a_bad_start_is_no_reason_to_fail(case: Path, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A point that fails from its neighbour's state is solved as `run` would solve it."""
    good = ContactSolver._attempt
    calls: Counter[str] = Counter()

    def bad_when_warm(self: ContactSolver, *given: Any) -> Any:
        warm = bool(self.last[0])
        calls["warm" if warm else "cold"] += 1
        result = good(self, *given)
        return replace(result, converged=False, reason="lost") if warm else result

    monkeypatch.setattr(ContactSolver, "_attempt", bad_when_warm)
    assert call("sweep", case, *OVER, "-o", folder).returncode == 0
    assert calls == {"cold": 3, "warm": 2}


def test_an_item_that_kills_its_processes_is_given_up(folder: Path) -> None:
    tasks = [DeadlyTask(("a", "deadly", "b"), str(folder)), *(DeadlyTask((f"c{n}", f"d{n}"), str(folder)) for n in range(3))]
    notes: list[str] = []
    with Journal(folder / "j.jsonl", {"kind": "test"}, resume=False) as journal:
        found = list(run(tasks, journal, Workers(jobs=2), notes.append))
        assert sorted(found) == sorted(["a", "deadly", "b", *(f"{letter}{n}" for n in range(3) for letter in "cd")])
        assert [key for key in journal if journal[key]["reason"]] == ["deadly"]
        assert "died 3 times" in journal["deadly"]["reason"]
    # Once beside others; then alone, where it counts.
    assert 3 <= len((folder / "deaths").read_text()) <= 5
    assert notes and set(notes) == {"a worker process died; its points are solved again"}


def test_a_process_that_dies_while_it_has_nothing_to_do_is_replaced(folder: Path) -> None:
    tasks = (DeadlyTask((name,), str(folder)) for name in "ab")
    with Journal(folder / "j.jsonl", {"kind": "test"}, resume=False) as journal:
        found = run((task for task in tasks), journal, Workers(jobs=2), lambda text: None)
        first = next(found)
        for worker in multiprocessing.active_children():
            worker.kill()
        while any("ExecutorManager" in type(thread).__name__ for thread in threading.enumerate()):
            time.sleep(0.005)  # until its end has been noticed
        assert sorted([first, *found]) == ["a", "b"]


def test_a_process_that_is_stopped_finishes_the_file_that_it_writes(folder: Path) -> None:
    """The other process has nothing to write and ends at once; its pool then stops the one that writes."""
    with Journal(folder / "j.jsonl", {"kind": "test"}, resume=False) as journal:
        tasks = [SlowDiskTask(("slow", "never"), str(folder)), DeadlyTask(("quick",), str(folder))]
        found = run(tasks, journal, Workers(jobs=2), lambda text: None)
        assert next(found) == "quick"
        while not list(folder.glob("*.part")):
            time.sleep(0.005)
        found.close()
        assert journal.update() == ["slow"]
        assert sorted(path.name for path in folder.iterdir() if path.suffix != ".lock") == ["j.jsonl", "slow.bin"]


def test_an_invalid_sweep_has_a_json_record(case: Path, tmp_path: Path) -> None:
    for key, value in (("load.normal_N", "-1"), ("force.longitudinal_N", "1e9")):
        done = call("sweep", case, "--over", f"{key}={value},1", "-o", tmp_path, "--json")
        record = json.loads(done.stdout)
        assert (done.returncode, record["valid"], [error["key"] for error in record["errors"]]) == (3, False, [key])


# --- the journal ---------------------------------------------------------------------------------------------------


def test_a_torn_line_of_the_journal_is_dropped_and_the_latest_record_counts(folder: Path) -> None:
    path = folder / "j.jsonl"
    with Journal(path, {"kind": "test"}, resume=False) as journal:
        for value in (1, 2):
            journal.keep({"key": "a", "value": value})
        journal.keep({"key": "b", "value": 3})
    with open(path, "ab") as stream:
        stream.write(b'{"key": "c", "value": 4')
    with Journal(path, {"kind": "test"}, resume=True) as journal:
        assert {key: journal[key]["value"] for key in journal} == {"a": 2, "b": 3}
        journal.keep({"key": "c", "value": 5})
        assert journal.update() == ["c"] and journal["c"]["value"] == 5
        with pytest.raises(JournalError, match="in use"):
            Journal(path, {"kind": "test"}, resume=True)
    # A line of something else, which only looks like a record.
    with open(path, "ab") as stream:
        stream.write(b'{"key": "a", "other": 1}\n["key"]\n3\n')
    with Journal(path, {"kind": "test"}, resume=True, fields=["value"]) as journal:
        assert {key: journal[key]["value"] for key in journal} == {"a": 2, "b": 3, "c": 5}
    with pytest.raises(JournalError, match="of another table"):
        Journal(path, {"kind": "table"}, resume=True)
    with Journal(path, {"kind": "table"}, resume=False) as journal:
        assert len(journal) == 0


# --- files found on resuming ---------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def swept(tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("swept")
    (place / "spheres.toml").write_text(CASE)
    assert call("sweep", place / "spheres.toml", *OVER, "-o", place / "out", "-q").returncode == 0
    return place / "out"


@pytest.fixture
def finished(swept: Path, folder: Path) -> Path:
    return Path(shutil.copytree(swept, folder, dirs_exist_ok=True))


def truncate(path: Path) -> None:
    path.write_bytes(path.read_bytes()[:-5000])


@pytest.mark.parametrize("damage", [truncate, Path.unlink])
def test_damaged_files_are_told_and_solved_again(damage: Any, case: Path, finished: Path) -> None:
    table = (finished / "sweep.csv").read_bytes()
    before = read_result(finished / "spheres_0002.h5").coupled.fields["pressure"]
    damage(finished / "spheres_0002.h5")
    done = call("sweep", case, *OVER, "-o", finished, "--resume")
    assert done.returncode == 0
    assert "spheres_0002.h5: not there, or not as it was written; solved again" in done.stderr
    assert "2 of 3 points are finished already" in done.stderr
    assert (finished / "sweep.csv").read_bytes() == table
    assert (read_result(finished / "spheres_0002.h5").coupled.fields["pressure"] == before).all()


# --- folders -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("other", [("--over", "load.normal_N=50,65"), (*OVER, "--set", "load.normal_N=70")])
def test_a_finished_sweep_of_other_points_is_not_lost(other: tuple[str, ...], case: Path, finished: Path) -> None:
    before = {path.name: path.read_bytes() for path in finished.iterdir()}
    done = call("sweep", case, *other, "-o", finished, "--no-plots")
    assert (done.returncode, done.stdout) == (5, "")
    assert f"{finished} has a sweep of 3 points of spheres over creepage.longitudinal, 3 of which are not among" in done.stderr
    assert other[1].partition("=")[0] in done.stderr and "--resume" in done.stderr and "--force" in done.stderr
    assert {path.name: path.read_bytes() for path in finished.iterdir()} == before
    assert call("sweep", case, *other, "-o", finished, "--no-plots", "--force", "--resume").returncode == 2
    assert {path.name: path.read_bytes() for path in finished.iterdir()} == before
    assert call("sweep", case, *other, "-o", finished, "--no-plots", "--force").returncode == 0
    keys = {other[1].partition("=")[0]} & {*rows(finished)[0]}
    assert keys and {path.name for path in finished.glob("*.h5")} == {row["file"] for row in rows(finished)}


def test_the_same_sweep_begins_anew_without_a_word(case: Path, finished: Path) -> None:
    done = call("sweep", case, *OVER, "-o", finished)
    assert done.returncode == 0 and "finished already" not in done.stderr


def test_two_sweeps_in_one_folder(case: Path, finished: Path) -> None:
    before = {path.name: path.read_bytes() for path in finished.iterdir()}
    with Journal(finished / JOURNAL_NAME, {"kind": "sweep", "format": JOURNAL_FORMAT}, resume=True):
        done = call("sweep", case, *OVER, "-o", finished)
        assert (done.returncode, done.stdout) == (5, "")
        assert "another process works in" in done.stderr and "use another folder" in done.stderr
    assert {path.name: path.read_bytes() for path in finished.iterdir()} == before


def test_a_full_disk_keeps_what_was_finished(case: Path, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from thermoroll_cli.tools import journal

    good = journal.write_bytes

    def full(path: Path, content: bytes) -> None:
        if path.stem == "spheres_0003":
            raise WriteError(path, OSError(errno.ENOSPC, os.strerror(errno.ENOSPC)))
        good(path, content)

    monkeypatch.setattr(journal, "write_bytes", full)
    done = call("sweep", case, *OVER, "-o", folder)
    assert (done.returncode, done.stdout) == (5, "")
    assert "spheres_0003.h5: No space left on device" in done.stderr
    assert sorted(path.name for path in folder.iterdir()) == ["spheres_0001.h5", "spheres_0002.h5", "sweep.csv", "sweep.jsonl"]
    assert len(rows(folder)) == 2


def test_a_full_disk_and_scalars_only(case: Path, folder: Path) -> None:
    """HDF5 itself crashes if its file cannot be written to the end."""
    done = limited(folder, 30000, "sweep", case, *OVER, "-o", folder, "--scalars-only", "-q")
    assert done.stderr == f"thermoroll: error: cannot write {folder / 'sweep.h5'}: File too large\n"
    assert (done.returncode, sorted(path.name for path in folder.iterdir())) == (5, ["sweep.csv", "sweep.jsonl"])


# --- streams -------------------------------------------------------------------------------------------------------


def test_a_bar_with_the_time_left_on_terminals(case: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(streams, "is_terminal", lambda stream: True)
    for name, value in {"TERM": "xterm", "FORCE_COLOR": "1", "TTY_COMPATIBLE": "1", "COLUMNS": "120"}.items():
        monkeypatch.setenv(name, value)
    shown = call("sweep", case, *OVER, "-o", tmp_path).stderr
    assert "0/3 points" in shown and "\x1b[2K" in shown
    assert "3/3 points" in shown and "\u2501" in shown
    quiet = call("sweep", case, *OVER, "-q", "-o", tmp_path)
    assert (quiet.stdout, quiet.stderr) == ("", "")
    monkeypatch.setenv("COLUMNS", "20")
    narrow = call("sweep", case, *OVER, "-o", tmp_path).stderr
    assert "0/3 points" in narrow and "\u2501" not in narrow


def test_a_batch_is_solved_from_its_start_but_only_pending_points_are_kept() -> None:
    points = Points((Base(MECHANICAL, "case.toml", "case"),), parse_axes(["creepage.longitudinal=0.001:0.002:4"]))
    whole = Batch(points, range(1, 5), tuple(Pending(n, str(n), f"{n}.h5") for n in range(1, 5)), "thermoroll sweep")
    part = whole.without(lambda key: key in ("1", "2", "4"))
    assert part is not None
    ((record, files),) = part.items()
    assert (record["key"], record["file"], files["3.h5"][:4]) == ("3", "3.h5", b"\x89HDF")
    assert record["summary"]["Q_F_W"] == list(whole.items())[2][0]["summary"]["Q_F_W"]
    assert whole.without(lambda key: True) is None


def test_leftovers_of_killed_processes_are_removed(tmp_path: Path) -> None:
    abandoned, being_written = (tmp_path / f".thermoroll-{name}.part" for name in ("old", "new"))
    for path in (abandoned, being_written):
        path.write_bytes(b"half of a file")
    os.utime(abandoned, (0.0, time.time() - 2.0 * atomic.ABANDONED_SECONDS))
    atomic.remove_leftovers(tmp_path)
    assert (abandoned.exists(), being_written.exists()) == (False, True)


# --- several sweeps in one folder, and starts that fail --------------------------------------------------------------


@pytest.mark.parametrize("seed", sampled(range(3), 3))
def test_each_row_names_a_file_of_its_own_point_whatever_was_swept_here(seed: int, case: Path, folder: Path) -> None:
    """Sweeps that share points, values and names, resumed in a random order and number."""
    choose = random.Random(seed)
    three = "--over", "creepage.longitudinal=0.001,0.002,0.003"
    sweeps = [three, ("--over", "creepage.longitudinal=0.0005,0.001,0.0015"), ("--over", "load.normal_N=50,65"),
              ("--set", "load.normal_N=70", *three)]
    for options in choose.choices(sweeps, k=5):
        done = call("sweep", case, *options, "--no-plots", "-o", folder, *choose.choice([("--resume",), ("--resume", "-q")]))
        assert done.returncode == 0, done.stderr
        given = float(options[1].partition("=")[2]) if options[0] == "--set" else 65.0
        for row in rows(folder):
            result = read_result(folder / row["file"])
            assert result.problem.normal_force == pytest.approx(float(row.get("load.normal_N", given)))
            if "creepage.longitudinal" in row:
                assert result.problem.motion.creepage_x == pytest.approx(float(row["creepage.longitudinal"]))
            assert result.numbers["force_x_N"] == float(row["force_x_N"])


def test_a_start_that_fails_leaves_the_last_sweep_as_it_was(
    case: Path, finished: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = {path.name: path.read_bytes() for path in finished.iterdir()}
    monkeypatch.setattr("thermoroll_cli.studies.sweeps.sweep.run", refused)
    assert call("sweep", case, *OVER, "-o", finished).returncode == 5
    assert {path.name: path.read_bytes() for path in finished.iterdir()} == before


def refused(*given: Any) -> Iterator[str]:
    raise OSError("no cluster")
    yield
