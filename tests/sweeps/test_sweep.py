"""Whole sweeps: the same results in one process, in two, on a cluster, after deaths and interruptions."""

from __future__ import annotations

import csv
import json
import math
import os
import signal
import subprocess
import time
from collections.abc import Callable, Iterator
from concurrent.futures import CancelledError, Future, ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np
import pytest

from tests.support.command_line import COMMAND, PATIENCE, THERMAL, Called, call, environment
from tests.support.datasets import datasets
from thermoroll_cli.files.result.outcome import read_result
from thermoroll_cli.problem.names import OVER_LIMIT, PROBLEM_SCALARS, SCALARS
from thermoroll_cli.tools.atomic import WriteError
from thermoroll_cli.tools.runner import Item, _Cluster

HOT = THERMAL.replace("speed_m_s = 1.0", "speed_m_s = 100.0") + '[thermal]\npeclet = "stationary"\ndeformation = false\n'
"""The article's hot spheres."""

LOAD, KEY = "load.normal_N", "creepage.longitudinal"
ROW = 5
POINTS = 2 * ROW
SWEEP = ("--over", f"{LOAD}=60,65", "--over", f"{KEY}=0.0005:0.006:{ROW}")
"""Two batches, of 16 elements."""


@dataclass(frozen=True)
class Swept:
    """A finished sweep: its folder and what was printed."""

    folder: Path
    case: Path
    done: Called

    @property
    def table(self) -> bytes:
        return (self.folder / "sweep.csv").read_bytes()

    @property
    def rows(self) -> list[dict[str, str]]:
        return list(csv.DictReader(self.table.decode().splitlines()))


@pytest.fixture(scope="module")
def case(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("case") / "spheres.toml"
    path.write_text(HOT)
    return path


@pytest.fixture(scope="module")
def serial(case: Path, tmp_path_factory: pytest.TempPathFactory) -> Swept:
    """The sweep that all others are compared with: one process, never interrupted."""
    folder = tmp_path_factory.mktemp("serial")
    return Swept(folder, case, call("sweep", case, *SWEEP, "-o", folder, "--json"))


def files(folder: Path) -> list[Path]:
    return sorted(folder.glob("*.h5"))


def assert_same(folder: Path, serial: Swept) -> None:
    """Tables equal to the last digit, files equal to the last bit, nothing left over but what a killed process was just writing
    (another sweep may be writing it: it goes once it is old, `atomic.remove_leftovers`)."""
    assert (folder / "sweep.csv").read_bytes() == serial.table
    assert [path.name for path in files(folder)] == [path.name for path in files(serial.folder)]
    for mine, other in zip(files(folder), files(serial.folder), strict=True):
        assert datasets(mine) == datasets(other), mine.name
    left = {path.name for path in folder.iterdir() if path.suffix != ".part"}
    assert left <= {path.name for path in serial.folder.iterdir()}


# --- what a sweep writes -------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_one_file_per_point_a_table_a_picture(serial: Swept) -> None:
    assert serial.done.returncode == 0
    names = [f"spheres_{number:04d}" for number in range(1, POINTS + 1)]
    expected = [f"{name}.h5" for name in names] + ["sweep.csv", "sweep.jsonl", "sweep.png"]
    assert sorted(path.name for path in serial.folder.iterdir()) == expected
    assert (serial.folder / "sweep.png").read_bytes().startswith(b"\x89PNG")
    assert [row["file"] for row in serial.rows] == [f"{name}.h5" for name in names]
    values = np.array([float(row[KEY]) for row in serial.rows])
    np.testing.assert_allclose(values, [*np.linspace(0.0005, 0.006, ROW)] * 2, rtol=1e-11)
    stored = read_result(serial.folder / "spheres_0003.h5")
    assert (stored.converged, stored.case_text) == (True, HOT)
    assert json.loads(stored.case_json)["creepage"]["longitudinal"] == values[2]
    assert stored.attributes["command_line"].startswith("thermoroll sweep")


def test_columns_have_the_public_names(serial: Swept) -> None:
    states = [f"{state}.{name}" for state in ("isothermal", "uncertainty") for name in SCALARS]
    scalars = [*SCALARS, *PROBLEM_SCALARS, *OVER_LIMIT]
    texts = ("reason", "unbounded", "warnings")
    over_limit = [f"uncertainty.{name}" for name in OVER_LIMIT]
    every = [LOAD, KEY, "status", *texts, *scalars, *states, *over_limit, "work.grid", "work.applications", "file"]
    # Without those that hold no number at any point.
    assert list(serial.rows[0]) == [name for name in every if name in serial.rows[0]]
    assert {"Q_F_W", "isothermal.gamma_p", "uncertainty.force_x_N"} <= serial.rows[0].keys()
    assert all(any(row[name] for row in serial.rows) for name in serial.rows[0].keys() - set(texts))
    for row in serial.rows:
        for prefix in ("", "uncertainty."):
            assert float(row[f"{prefix}force_x_over_friction_limit"]) == pytest.approx(
                float(row[f"{prefix}force_x_N"]) / (0.3 * float(row[LOAD])), rel=1e-12)


def test_json_table_and_files_agree_and_are_in_order(serial: Swept) -> None:
    records = [json.loads(line) for line in serial.done.stdout.splitlines()]
    assert [record["name"] for record in records] == [path.stem for path in files(serial.folder)]
    for record, row, path in zip(records, serial.rows, files(serial.folder), strict=True):
        stored = read_result(path, with_fields=False)
        assert record["status"] == row["status"] == "converged"
        assert record["over"] == {LOAD: float(row[LOAD]), KEY: float(row[KEY])}
        assert record["files"] == [str(path)]
        for name in (*SCALARS, *PROBLEM_SCALARS):
            value = stored.summary()[name]
            assert record[name] == (None if math.isnan(value) else value)
            assert row.get(name, "") == ("" if math.isnan(value) else repr(value))
        assert float(row["isothermal.Q_F_W"]) == record["isothermal"]["Q_F_W"] == stored.summary()["isothermal"]["Q_F_W"]
        assert record["work"]["grid"] == [16, 16]
        assert row["work.grid"] == "16x16"


def test_progress_is_a_line_per_point_where_nobody_watches(serial: Swept) -> None:
    lines = serial.done.stderr.splitlines()
    assert len(lines) == POINTS
    assert lines[0].startswith(f"1/{POINTS} spheres_0001: {LOAD} = 60, {KEY} = 0.0005: converged; ")
    assert lines[0].endswith(" left")
    assert "\x1b" not in serial.done.stderr


@pytest.mark.slow
def test_several_keys_a_printed_table_and_other_pictures(case: Path, tmp_path: Path) -> None:
    keys = ("--over", "load.normal_N=50,100", "--over", "rolling.speed_m_s=25:100:2:log")
    coupled = ("--set", "numerics.grid=8", "--set", "thermal.deformation=true", "-o", tmp_path)
    done = call("sweep", case, *keys, *coupled, "--format", "svg")
    assert done.returncode == 0
    rows = list(csv.DictReader((tmp_path / "sweep.csv").read_text().splitlines()))
    swept = [(row["load.normal_N"], row["rolling.speed_m_s"]) for row in rows]
    assert swept == [("50", "25"), ("50", "100"), ("100", "25"), ("100", "100")]
    header = [line.split() for line in done.stdout.splitlines()[:5]]
    assert any(words[:2] == ["load.", "rolling."] for words in header)
    assert any(words[:3] == ["normal_N", "speed_m_s", "Q_F_W"] for words in header)
    assert "4 of 4 points converged" in done.stdout
    assert (tmp_path / "sweep.svg").read_text().startswith("<?xml")
    # A warm start changes how a point is found, not what is found.
    last = ("--set", "load.normal_N=100", "--set", "rolling.speed_m_s=100")
    single = json.loads(call("run", case, *last, *coupled, "--no-plots", "--json", "-q").stdout)
    for name in ("Q_F_W", "gamma_c", "gamma_p", "force_x_N", "temperature_rise_max_lower_K"):
        assert float(rows[3][name]) == pytest.approx(single[name], rel=5e-4)


def test_quiet_without_pictures_and_from_standard_input(tmp_path: Path) -> None:
    options = ("--over", "numerics.grid=8,16", "-o", tmp_path, "--no-plots", "-q")
    done = call("sweep", "-", *options, stdin=HOT)
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["stdin_0001.h5", "stdin_0002.h5", "sweep.csv", "sweep.jsonl"]
    assert [read_result(path).x.size for path in files(tmp_path)] == [8, 16]
    call("sweep", "-", *options[:4], stdin=HOT + "[output]\nplots = false\n")
    assert not (tmp_path / "sweep.png").exists()


# --- the same sweep otherwise --------------------------------------------------------------------------------------


@contextmanager
def started(case: Path, folder: Path, *options: str) -> Iterator[subprocess.Popen[str]]:
    """The sweep as a process group of its own, as a terminal would start it."""
    words = [*COMMAND, "sweep", str(case), *SWEEP, "-o", str(folder), "--no-plots", *options]
    pipe = subprocess.PIPE
    process = subprocess.Popen(words, stdout=pipe, stderr=pipe, text=True, env=environment({}), start_new_session=True)
    with process:
        try:
            yield process
        finally:
            process.kill()


def wait_for(happened: Callable[[], bool], process: subprocess.Popen[str]) -> None:
    deadline = time.monotonic() + PATIENCE
    while not happened():
        assert process.poll() is None, f"ended too early: {process.communicate()}"
        assert time.monotonic() < deadline
        time.sleep(0.002)


def test_two_processes_give_the_serial_files(case: Path, serial: Swept, tmp_path: Path) -> None:
    done = call("sweep", case, *SWEEP, "-o", tmp_path, "--no-plots", "--jobs", "2", "--json")
    assert done.returncode == 0, done.stderr
    assert_same(tmp_path, serial)
    assert [json.loads(line)["name"] for line in done.stdout.splitlines()] == [path.stem for path in files(serial.folder)]


@pytest.mark.slow
@pytest.mark.parametrize(("name", "jobs", "code"), [("SIGKILL", "2", -9), ("SIGINT", "2", 130)])
def test_a_killed_sweep_is_resumed(name: str, jobs: str, code: int, case: Path, serial: Swept, tmp_path: Path) -> None:
    with started(case, tmp_path, "--jobs", jobs) as process:
        wait_for(lambda: len(files(tmp_path)) >= 3, process)
        # SIGINT comes from a terminal, which sends it to all processes.
        send = os.killpg if name == "SIGINT" else os.kill
        send(process.pid, getattr(signal, name))
        out, err = process.communicate(timeout=PATIENCE)
    assert (process.returncode, out) == (code, "")
    assert "Traceback" not in err
    if code > 0:
        assert "stopped by" in err
        assert len((tmp_path / "sweep.csv").read_text().splitlines()) > 2
        assert not list(tmp_path.glob(".*"))
    time.sleep(0.2)  # worker processes of a killed one end by themselves
    before = {path: path.stat().st_mtime_ns for path in files(tmp_path)}
    assert 3 <= len(before) < POINTS
    done = call("sweep", case, *SWEEP, "-o", tmp_path, "--resume", "--no-plots")
    assert done.returncode == 0
    assert f"{len(before)} of {POINTS} points are finished already" in done.stderr
    assert_same(tmp_path, serial)
    assert before == {path: path.stat().st_mtime_ns for path in before}


@pytest.mark.slow
@pytest.mark.parametrize("workers", [1, 2])
def test_a_cluster_gives_the_serial_files_and_may_lose_one(workers: int, case: Path, serial: Swept, tmp_path: Path) -> None:
    """Dask workers reachable from this machine only, of which the second one is killed."""
    import distributed

    def lose(worker: Any) -> None:
        while not files(tmp_path):
            time.sleep(0.002)
        worker.close_gracefully()  # no other takes its place
        os.kill(worker.process.pid, signal.SIGKILL)

    with mock.patch.dict(os.environ), distributed.LocalCluster(  # Dask sets variables of this process
        n_workers=workers, threads_per_worker=1, host="127.0.0.1", dashboard_address="127.0.0.1:0", silence_logs="CRITICAL"
    ) as cluster, ThreadPoolExecutor(1) as aside:
        lost = [aside.submit(lose, worker) for worker in list(cluster.workers.values())[1:]]
        done = call("sweep", case, *SWEEP, "-o", tmp_path, "--no-plots", "--dask", cluster.scheduler_address, "--json")
        assert [future.result() for future in lost] == [None] * (workers - 1)
    assert (done.returncode, len(done.stdout.splitlines())) == (0, POINTS), done.stderr
    assert_same(tmp_path, serial)


def test_no_cluster_there(case: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("thermoroll_cli.tools.runner.CONNECT_SECONDS", 0.5)
    for address in ("tcp://127.0.0.1:1", "foo"):
        done = call("sweep", case, *SWEEP, "-o", tmp_path, "--dask", address)
        assert (done.returncode, done.stdout) == (5, "")
        assert f"no Dask scheduler at {address}" in done.stderr


def test_a_cluster_without_workers_is_waited_for_and_given_up(case: Path, tmp_path: Path) -> None:
    import distributed

    with mock.patch.dict(os.environ), distributed.LocalCluster(
        n_workers=0, host="127.0.0.1", dashboard_address="127.0.0.1:0"
    ) as cluster:
        done = call("sweep", case, *SWEEP, "-o", tmp_path, "--dask", cluster.scheduler_address, "--dask-wait", "0.3")
    waiting, gave_up = done.stderr.splitlines()
    assert waiting == f"thermoroll: waiting for a worker of the Dask cluster at {cluster.scheduler_address}, 0.3 s at most"
    assert (done.returncode, gave_up.endswith("had no worker for 0.3 s; --dask-wait waits longer")) == (5, True)


@pytest.mark.parametrize(("raised", "client", "kind", "told"), [
    (ModuleNotFoundError("No module named 'fftw'"), "running", OSError, "lack a package of thermoroll: No module named 'fftw'"),
    (CancelledError(), "running", OSError, "scheduler at tcp://x went away; --resume"),
    (KeyError("workers"), "connecting", OSError, "scheduler at tcp://x went away; --resume"),
    (KeyError("workers"), "running", KeyError, "workers"),
    (WriteError(Path("a.h5"), OSError(28, "No space")), "closed", OSError, "cannot write a.h5: No space"),
])
def test_what_a_cluster_answers_instead_of_a_result(raised: Exception, client: str, kind: type[Exception], told: str) -> None:
    """A client without its scheduler fails in many ways, also as it is closed."""
    cluster, future = object.__new__(_Cluster), Future[list[Item]]()
    cluster._address, cluster._silent, cluster._executor = "tcp://x", [], mock.Mock()
    cluster._client = mock.Mock(status=client)
    if told.startswith("scheduler"):
        cluster._client.close.side_effect = ValueError("closed")
    future.set_exception(raised)
    with pytest.raises(kind, match=told), cluster:
        cluster.result(future)


def test_dask_is_an_extra(case: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    done = call("sweep", case, *SWEEP, "-o", tmp_path / "out", "--dask", "tcp://127.0.0.1:1")
    assert done.returncode == 2
    assert "pip install 'thermoroll[dask]'" in done.stderr
    assert not (tmp_path / "out").exists()


def test_a_sweep_of_several_cases_is_the_sweeps_of_each_in_one_table(tmp_path: Path) -> None:
    """To the last bit; begun with one case, the other is added with --resume. The picture has a curve of each."""
    texts = {"dry": THERMAL, "wet": THERMAL.replace("coefficient = 0.3", "coefficient = 0.1")}
    cases = [tmp_path / f"{name}.toml" for name in texts]
    for path, text in zip(cases, texts.values(), strict=True):
        path.write_text(text.replace("Two spheres", path.stem).replace("grid = 16", "grid = 8"))
    over = ("--over", f"{KEY}=0.001:0.004:3", "-q")
    for path in cases:
        assert call("sweep", path, *over, "-o", tmp_path / path.stem, "--no-plots").returncode == 0
    alone = [list(csv.reader((tmp_path / name / "sweep.csv").read_text().splitlines())) for name in texts]
    assert call("sweep", cases[0], *over, "-o", tmp_path / "both", "--no-plots").returncode == 0
    other = call("sweep", *cases, over[0], f"{KEY}=0.002,0.003", "-o", tmp_path / "both", "--no-plots")
    assert other.returncode == 5 and "3 points of dry over creepage.longitudinal, 3 of" in " ".join(other.stderr.split())
    done = call("sweep", *cases, *over, "-o", tmp_path / "both", "--resume", "--json", "--format", "svg", painted=True)
    assert done.returncode == 0
    table = list(csv.reader((tmp_path / "both" / "sweep.csv").read_text().splitlines()))
    rows = [[name, *row] for name, (_, *own) in zip(texts, alone, strict=True) for row in own]
    assert table == [["case", *alone[0][0]], *rows]
    records = [json.loads(line) for line in done.stdout.splitlines()]
    assert [(one["name"], one["title"], one["over"]["case"]) for one in records] == [
        (f"{name}_000{number}", name, name) for name in texts for number in (1, 2, 3)]
    assert all(f">{name}<" in (tmp_path / "both" / "sweep.svg").read_text() for name in texts)
    over_time = tmp_path / "over_time.toml"
    over_time.write_text(cases[0].read_text() + "[history]\ndistance_mm = [0.0, 0.1]\nsteps = 2\n")
    unlike = call("sweep", cases[0], over_time, *over, "-o", tmp_path / "no")
    assert unlike.returncode == 3 and "this is a single contact over time, and" in " ".join(unlike.stderr.split())
    unlike = call("sweep", cases[0], Path(__file__).parents[2] / "cases" / "angular_contact.toml",
                  "--over", "numerics.grid=8,12", "-o", tmp_path / "no")
    assert unlike.returncode == 3 and "this is a ball bearing, and" in " ".join(unlike.stderr.split())
    assert not (tmp_path / "no").exists()
