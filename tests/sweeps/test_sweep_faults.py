"""Sweeps when something goes wrong: points that fail, files that are damaged, folders that are taken or full."""

from __future__ import annotations

import csv
import errno
import json
import multiprocessing
import os
import resource
import shutil
import socket
import subprocess
import sys
import threading
import time
from collections import Counter
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from tests.support.command_line import COMMAND, MECHANICAL, PATIENCE, THERMAL, call, environment, on_terminal
from thermoroll_cli.files.atomic import WriteError
from thermoroll_cli.files.result.hdf5 import read_result
from thermoroll_cli.refinement.solve import Solver
from thermoroll_cli.sweeps.axis import parse_axes
from thermoroll_cli.sweeps.lock import LOCK_NAME, FolderInUse, sole_sweep
from thermoroll_cli.sweeps.points import Stretch, make_points
from thermoroll_cli.sweeps.processes import in_processes
from thermoroll_cli.sweeps.stretch import Outcome, Target, solve_into

OVER = ("--over", "creepage.longitudinal=0.001:0.002:3", "--no-plots")


@pytest.fixture
def case(tmp_path: Path) -> Path:
    path = tmp_path / "spheres.toml"
    path.write_text(MECHANICAL)
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
    options = ("--over", "rolling.speed_m_s=2e3,50", "--set", "numerics.grid=8", "--json", "-o", folder)
    done = call("sweep", hot, *options)
    assert done.returncode == 4
    records = [json.loads(line) for line in done.stdout.splitlines()]
    assert [record["status"] for record in records] == ["not_converged", "converged"]
    assert [row["status"] for row in rows(folder)] == ["not_converged", "converged"]
    assert rows(folder)[0]["reason"] == records[0]["reason"] != ""
    assert f"hot_0001 did not converge: {records[0]['reason']}" in done.stderr
    assert not read_result(folder / "hot_0001.h5").converged
    # Trying again would end the same way.
    again = call("sweep", hot, *options, "--resume", "--no-plots")
    assert (again.returncode, again.stdout) == (4, done.stdout)
    assert "2 of 2 points are finished already" in again.stderr


@pytest.mark.parametrize(
    ("cause", "reason"), [(ZeroDivisionError("by zero"), "ZeroDivisionError: by zero"), (MemoryError(), "not enough memory")]
)
def test_an_exception_is_a_row_and_is_tried_again(
    cause: Exception, reason: str, case: Path, folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    good = Solver.solve

    def bad_at_one(self: Solver, problem: Any, **options: Any) -> Any:
        if problem.motion.creepage_x == 0.0015:
            raise cause
        return good(self, problem, **options)

    with monkeypatch.context() as patch:
        patch.setattr(Solver, "solve", bad_at_one)
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
    good = Solver.solve
    calls: Counter[Solver] = Counter()

    def bad_when_warm(self: Solver, problem: Any, **options: Any) -> Any:
        calls[self] += 1
        result = good(self, problem, **options)
        return replace(result, converged=False, reason="lost") if calls[self] > 1 else result

    monkeypatch.setattr(Solver, "solve", bad_when_warm)
    assert call("sweep", case, *OVER, "-o", folder).returncode == 0
    assert sorted(calls.values()) == [1, 2, 2]


class Deadly:
    """A problem that kills the process that looks at it."""

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):  # pickle looks for its own
            raise AttributeError(name)
        os._exit(9)


def test_a_point_that_kills_its_processes_is_given_up(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("thermoroll_cli.sweeps.processes.DEATHS_PER_POINT", 2)
    axes = parse_axes(["creepage.longitudinal=0.001:0.003:3"])
    points = list(make_points(MECHANICAL, "case.toml", "case", axes))
    points[1] = replace(points[1], problem=Deadly())  # type: ignore[arg-type]
    notes: list[str] = []
    outcomes = list(in_processes([Stretch(tuple(points))], Target(folder, "thermoroll sweep"), 2, notes.append))
    by_number = sorted(outcomes, key=lambda outcome: outcome.number)
    assert [outcome.number for outcome in by_number] == [1, 2, 3]
    assert [bool(outcome.reason) for outcome in by_number] == [False, True, False]
    assert "died 2 times" in by_number[1].reason
    assert sorted(path.name for path in folder.iterdir()) == ["case_0001.h5", "case_0003.h5"]
    assert len(notes) == 2


def test_a_process_that_dies_while_it_has_nothing_to_do_is_replaced(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from thermoroll_cli.sweeps import processes

    monkeypatch.setattr(processes, "_mark", lambda path: ())  # files tell nothing before the stretch is done
    axes = parse_axes(["creepage.longitudinal=0.001,0.002"])
    stretches = [Stretch((point,)) for point in make_points(MECHANICAL, "case.toml", "case", axes)]
    outcomes = in_processes(stretches, Target(folder, "thermoroll sweep"), 1, pytest.fail)
    numbers = [next(outcomes).number]
    (worker,) = multiprocessing.active_children()
    worker.kill()
    while any("ExecutorManager" in type(thread).__name__ for thread in threading.enumerate()):
        time.sleep(0.005)  # until its end has been noticed
    numbers += [outcome.number for outcome in outcomes]
    assert numbers == [1, 2]
    assert sorted(path.name for path in folder.iterdir()) == ["case_0001.h5", "case_0002.h5"]


# --- files found on resuming ---------------------------------------------------------------------------------------


@pytest.fixture
def finished(case: Path, folder: Path) -> Path:
    assert call("sweep", case, *OVER, "-o", folder, "-q").returncode == 0
    return folder


def truncate(path: Path) -> None:
    path.write_bytes(path.read_bytes()[:-5000])


def replace_by_text(path: Path) -> None:
    path.write_text("not HDF5\n")


def damage_a_field(path: Path) -> None:
    content = bytearray(path.read_bytes())
    pressure = read_result(path).coupled.fields["pressure"].tobytes()
    content[content.index(pressure) + len(pressure) // 2] ^= 0x55
    path.write_bytes(content)


@pytest.mark.parametrize(
    ("damage", "told"),
    [(truncate, "truncated"), (replace_by_text, "not an HDF5 file"), (damage_a_field, "damaged"), (Path.unlink, "")],
)
def test_damaged_files_are_told_and_solved_again(damage: Any, told: str, case: Path, finished: Path) -> None:
    table = (finished / "sweep.csv").read_bytes()
    before = read_result(finished / "spheres_0002.h5").coupled.fields["pressure"]
    damage(finished / "spheres_0002.h5")
    done = call("sweep", case, *OVER, "-o", finished, "--resume")
    assert done.returncode == 0
    assert told in done.stderr
    assert ("spheres_0002.h5" in done.stderr) == bool(told)
    assert "2 of 3 points are finished already" in done.stderr
    assert (finished / "sweep.csv").read_bytes() == table
    assert (read_result(finished / "spheres_0002.h5").coupled.fields["pressure"] == before).all()


def test_points_are_recognised_by_their_case_not_their_name(case: Path, finished: Path) -> None:
    (finished / "spheres_0002.h5").rename(finished / "mine.h5")
    done = call("sweep", case, *OVER, "-o", finished, "--resume")
    assert "3 of 3 points are finished already" in done.stderr
    assert [row["file"] for row in rows(finished)] == ["spheres_0001.h5", "mine.h5", "spheres_0003.h5"]
    # More points in between: those that are there stay where they are, and no other takes their place.
    over = ("--over", "creepage.longitudinal=0.001:0.002:5", "--no-plots")
    done = call("sweep", case, *over, "-o", finished, "--resume")
    assert "3 of 5 points are finished already" in done.stderr
    names = [row["file"] for row in rows(finished)]
    assert names == ["spheres_0001.h5", "spheres_0002.h5", "mine.h5", "spheres_0004.h5", "spheres_0003.h5"]
    for row in rows(finished):
        content = json.loads(read_result(finished / row["file"]).case_json)
        assert content["creepage"]["longitudinal"] == float(row["creepage.longitudinal"])


def test_names_taken_by_other_points(case: Path, finished: Path) -> None:
    done = call("sweep", case, "--over", "creepage.longitudinal=0.0005,0.001", "--no-plots", "-o", finished, "--resume")
    assert done.returncode == 0
    assert [row["file"] for row in rows(finished)] == ["spheres_0003.h5", "spheres_0001.h5"]


def test_an_edited_case_is_another_case(case: Path, finished: Path) -> None:
    case.write_text(MECHANICAL.replace("normal_N = 65.0", "normal_N = 70.0"))
    done = call("sweep", case, *OVER, "-o", finished, "--resume")
    assert "finished already" not in done.stderr
    assert done.stderr.count("of another case; replaced") == 3
    assert {read_result(finished / row["file"]).problem.normal_force for row in rows(finished)} == {70.0}


# --- folders -------------------------------------------------------------------------------------------------------


def test_two_sweeps_in_one_folder(case: Path, folder: Path) -> None:
    with sole_sweep(folder):
        done = call("sweep", case, *OVER, "-o", folder)
        assert (done.returncode, done.stdout) == (5, "")
        assert "another sweep works in" in done.stderr
        assert f"process {os.getpid()} on {socket.gethostname()}" in done.stderr
    assert list(folder.iterdir()) == []


def test_the_lock_of_a_dead_process_is_taken_over(case: Path, folder: Path) -> None:
    gone = subprocess.Popen(["true"])
    gone.wait()
    (folder / LOCK_NAME).write_text(json.dumps({"pid": gone.pid, "host": socket.gethostname(), "started": "1"}))
    assert call("sweep", case, *OVER, "-o", folder, "-q").returncode == 0
    assert not list(folder.glob(".*"))


@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="needs /proc")
def test_a_number_that_now_belongs_to_another_process_holds_nothing(folder: Path) -> None:
    (folder / LOCK_NAME).write_text(json.dumps({"pid": os.getpid(), "host": socket.gethostname(), "started": "1"}))
    with sole_sweep(folder):
        pass


@pytest.mark.parametrize("text", ['{"pid": 1, "host": "elsewhere"}', "", "[]", "{"])
def test_a_lock_that_cannot_be_judged_is_respected(text: str, folder: Path) -> None:
    (folder / LOCK_NAME).write_text(text)
    with pytest.raises(FolderInUse, match="remove"), sole_sweep(folder):
        pass
    assert (folder / LOCK_NAME).read_text() == text


def test_locks_without_hard_links(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def no_links(*_: object) -> None:
        raise OSError(errno.EPERM, "Operation not permitted")

    monkeypatch.setattr(os, "link", no_links)
    with sole_sweep(folder), pytest.raises(FolderInUse), sole_sweep(folder):
        pass
    assert list(folder.iterdir()) == []


@pytest.mark.parametrize("place", ["file", "file/below"])
def test_folders_that_cannot_be(place: str, case: Path, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    done = call("sweep", case, *OVER, "-o", tmp_path / place)
    assert (done.returncode, done.stdout) == (5, "")
    assert "cannot write to" in done.stderr


def test_a_full_disk_keeps_what_was_finished(case: Path, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    import thermoroll_cli.sweeps.stretch as stretch

    good = stretch.write_result

    def full(path: Path, *arguments: Any, **options: Any) -> None:
        if path.stem == "spheres_0003":
            raise WriteError(path, OSError(errno.ENOSPC, ""))
        good(path, *arguments, **options)

    monkeypatch.setattr(stretch, "write_result", full)
    done = call("sweep", case, *OVER, "-o", folder)
    assert (done.returncode, done.stdout) == (5, "")
    assert "spheres_0003.h5: no space left on the device" in done.stderr
    assert sorted(path.name for path in folder.iterdir()) == ["spheres_0001.h5", "spheres_0002.h5", "sweep.csv"]
    assert len(rows(folder)) == 2


def test_a_full_disk_in_another_process(case: Path, folder: Path) -> None:
    done = subprocess.run(
        [*COMMAND, "sweep", str(case), *OVER, "-o", str(folder), "--jobs", "2"],
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (5000, 5000)),
        env=environment({}), capture_output=True, text=True, timeout=PATIENCE,
    )  # fmt: skip
    assert (done.returncode, done.stdout) == (5, "")
    assert "spheres_0001.h5: the file would be larger than allowed" in done.stderr
    assert not list(folder.glob("*.h5"))


# --- streams -------------------------------------------------------------------------------------------------------


def test_a_reader_that_goes_away_ends_the_sweep(case: Path, folder: Path) -> None:
    words = [*COMMAND, "sweep", str(case), "--over", "load.normal_N=1:100:40", "--json", "-q", "-o", str(folder)]
    with subprocess.Popen(words, stdout=subprocess.PIPE, text=True, env=environment({})) as process:
        assert process.stdout is not None
        assert json.loads(process.stdout.readline())["name"] == "spheres_0001"
        process.stdout.close()
    assert process.returncode == 141
    assert len(list(folder.glob("*.h5"))) < 40


def test_a_bar_with_the_time_left_on_terminals(case: Path, tmp_path: Path) -> None:
    shown = on_terminal(["sweep", case.name, *OVER], tmp_path)
    assert "] 0/3 points" in shown
    assert "] 1/3 points, " in shown
    assert " s left" in shown
    assert "\r\x1b[K" in shown
    shutil.rmtree(tmp_path / "results")
    assert on_terminal(["sweep", case.name, *OVER, "-q"], tmp_path) == ""


def test_a_stretch_is_solved_from_its_start_but_only_pending_points_are_written(folder: Path) -> None:
    axes = parse_axes(["creepage.longitudinal=0.001:0.002:4"])
    points = make_points(MECHANICAL, "case.toml", "case", axes)
    stretch = Stretch(points, finished=frozenset({1, 4}), given_up=frozenset({2}))
    outcomes: Iterator[Outcome] = solve_into(stretch, Target(folder, "thermoroll sweep"))
    assert [outcome.number for outcome in outcomes] == [3]
    assert [path.name for path in folder.iterdir()] == ["case_0003.h5"]


def test_leftovers_of_dead_processes_are_removed_and_those_of_living_ones_are_not(tmp_path: Path) -> None:
    from thermoroll_cli.files import atomic

    with subprocess.Popen([sys.executable, "-c", ""]) as gone:
        gone.wait()
    dead = tmp_path / f".thermoroll-{atomic._node()}-{gone.pid}-00000000.part"
    living = tmp_path / f".thermoroll-{atomic._node()}-{os.getpid()}-00000000.part"
    elsewhere = tmp_path / f".thermoroll-ffffffff-{gone.pid}-00000000.part"
    for path in (dead, living, elsewhere):
        path.write_bytes(b"half of a file")
    atomic.remove_leftovers(tmp_path)
    assert (dead.exists(), living.exists(), elsewhere.exists()) == (False, True, True)
