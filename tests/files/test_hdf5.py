"""Result files: what they hold, that they are whole or absent, and what is said about those that are not results."""

from __future__ import annotations

import dataclasses
import errno
import json
import os
import pathlib
import random
import shutil
import subprocess
import sys
from typing import Any

import h5py
import numpy as np
import pytest
import xarray

from tests.support import synthetic
from thermoroll_cli import __version__
from thermoroll_cli.files.result.labelled import Node, ResultFileError, load
from thermoroll_cli.files.result.outcome import read_result, write_result
from thermoroll_cli.problem.names import FIELDS
from thermoroll_cli.problem.result import Result
from thermoroll_cli.tools import atomic
from thermoroll_cli.tools.atomic import WriteError, write_bytes

ROOT = pathlib.Path(__file__).parents[2]
CASE_TEXT = '# Grüße\ntitle = "κ"\n'
CASE_JSON = '{"title": "κ"}'


def write(path: pathlib.Path, result: Result) -> pathlib.Path:
    write_result(path, dataclasses.replace(result, case_text=CASE_TEXT, case_json=CASE_JSON), "thermoroll run case.toml")
    return path


@pytest.fixture(scope="module")
def stored(tmp_path_factory: pytest.TempPathFactory) -> pathlib.Path:
    return write(tmp_path_factory.mktemp("results") / "näme with space.h5", synthetic.result((24, 16), aspect=2.0))


def test_everything_comes_back(stored: pathlib.Path) -> None:
    original = synthetic.result((24, 16), aspect=2.0)
    result = read_result(stored)
    assert result.case_text == CASE_TEXT and result.case_json == CASE_JSON
    assert result.problem == original.problem and result.converged is True
    assert result.attributes["program_version"] == __version__
    assert result.attributes["command_line"] == "thermoroll run case.toml"
    np.testing.assert_array_equal(result.x, original.x)
    np.testing.assert_array_equal(result.y, original.y)
    for state, found in ((original.coupled, result.coupled), (original.isothermal, result.isothermal)):
        assert set(found.fields) == set(state.fields) <= set(FIELDS)
        for name, values in state.fields.items():
            np.testing.assert_array_equal(found.fields[name], values)
    assert json.dumps(result.summary()) == json.dumps(original.summary())
    assert [*result.coupled.scalars] == [*original.coupled.scalars]
    assert set(result.residuals) == set(original.residuals)
    np.testing.assert_array_equal(result.residuals["coupling"], original.residuals["coupling"])


def test_states_that_are_the_same_stay_the_same(tmp_path: pathlib.Path) -> None:
    path = write(tmp_path / "one.h5", synthetic.result((16, 16), deformation=False))
    result = read_result(path)
    assert result.isothermal is result.coupled
    with h5py.File(path) as file:
        assert "isothermal" not in file


def test_nan_infinity_and_odd_texts_survive(tmp_path: pathlib.Path) -> None:
    original = synthetic.result((8, 8), heat=False, title="NUL \0 and lone \udc80 surrogate", converged=False)
    scalars = {**original.coupled.scalars, "gamma_p": float("nan"), "approach_um": float("inf")}
    coupled = dataclasses.replace(original.coupled, scalars=scalars)
    result = read_result(write(tmp_path / "odd.h5", dataclasses.replace(original, coupled=coupled, work={"a": np.pi})))
    title = "NUL \N{REPLACEMENT CHARACTER} and lone \\udc80 surrogate"
    assert result.problem.title == result.attributes["title"] == title
    assert result.converged is False and result.reason.startswith("the coupling iteration")
    assert np.isnan(result.coupled.scalars["gamma_p"]) and np.isinf(result.coupled.scalars["approach_um"])
    assert result.work == {"a": np.pi}


@pytest.mark.parametrize("group", ["fields", "isothermal/fields"])
def test_xarray_opens_the_fields_with_units(stored: pathlib.Path, group: str) -> None:
    with xarray.open_dataset(stored, group=group, engine="h5netcdf") as dataset:
        assert dict(dataset.sizes) == {"x": 24, "y": 16}
        assert dataset.x.attrs["units"] == "m"
        assert set(dataset.data_vars) == set(synthetic.result((8, 8)).coupled.fields)
        for name, field in dataset.data_vars.items():
            declared = FIELDS[str(name)]
            assert field.dims == ("x", "y")
            assert field.attrs == {"units": declared.unit, "long_name": declared.meaning, "axes": "x y"}
        # The trailing edge, where it is hot, is at +x.
        hottest = dataset.temperature_rise_lower.argmax(...)
        assert float(dataset.x[hottest["x"]]) > 0.0


@pytest.mark.slow
def test_xarray_opens_all_of_it(stored: pathlib.Path) -> None:
    numbers = read_result(stored).numbers
    with xarray.open_datatree(stored, engine="h5netcdf") as tree:
        tree.load()
        names = [name.decode() for name in tree["numbers/scalar"].values]
        assert dict(zip(names, tree["numbers/value"].values.tolist(), strict=True)) == numbers
        assert tree["residuals/coupling"].dims == ("coupling_iteration",) and "case_text" in tree["input"]


# Faults while writing


@pytest.mark.parametrize("number", [errno.ENOSPC, errno.EROFS, errno.EDQUOT, errno.EIO])
def test_a_failed_write_says_why_and_leaves_the_old_file(
    tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch, number: int
) -> None:
    target = tmp_path / "result.h5"
    target.write_bytes(b"old")

    def fail(descriptor: int) -> None:
        raise OSError(number, os.strerror(number))

    monkeypatch.setattr(atomic.os, "fsync", fail)
    with pytest.raises(WriteError, match=r"cannot write .*result\.h5: ") as caught:
        write(target, synthetic.result((8, 8)))
    assert isinstance(caught.value, OSError) and caught.value.errno == number
    assert target.read_bytes() == b"old" and os.listdir(tmp_path) == ["result.h5"]


@pytest.mark.parametrize("where", ["fsync", "replace"])
def test_an_interrupt_leaves_nothing(tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch, where: str) -> None:
    def interrupt(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(atomic.os, where, interrupt)
    with pytest.raises(KeyboardInterrupt):
        write(tmp_path / "result.h5", synthetic.result((8, 8)))
    assert os.listdir(tmp_path) == []


def test_places_that_cannot_hold_a_file(tmp_path: pathlib.Path) -> None:
    (tmp_path / "file").write_text("")
    (tmp_path / "locked").mkdir(mode=0o500)
    for place, message in (("absent/a.h5", "No such file"), ("", "Is a directory"),
                           ("a" * 300, "name too long"), ("file/a.h5", "Not a directory"),
                           ("locked/a.h5", "Permission denied")):
        if place != "locked/a.h5" or os.geteuid() != 0:
            with pytest.raises(WriteError, match=message):
                write_bytes(tmp_path / place, b"x")


def test_links_are_followed_devices_kept_and_the_umask_obeyed(tmp_path: pathlib.Path) -> None:
    (tmp_path / "real").write_bytes(b"old")
    (tmp_path / "link").symlink_to("real")
    program = "import sys; from thermoroll_cli.tools.atomic import write_bytes; write_bytes(sys.argv[1], b'new')"
    subprocess.run([sys.executable, "-c", program, tmp_path / "link"], cwd=ROOT, umask=0o027, check=True)
    assert (tmp_path / "link").is_symlink() and (tmp_path / "real").read_bytes() == b"new"
    assert (tmp_path / "real").stat().st_mode & 0o777 == 0o640
    write_bytes("/dev/null", b"gone")
    assert pathlib.Path("/dev/null").is_char_device()
    with pytest.raises(WriteError, match="No space left"):
        write_bytes("/dev/full", b"x")
    # As long as the file system allows; a temporary name derived from it would not fit.
    write_bytes(tmp_path / ("n" * 255), b"x")


# Files that are no results


def test_files_that_are_not_results_are_named(tmp_path: pathlib.Path, stored: pathlib.Path) -> None:
    def says(path: pathlib.Path, what: str) -> None:
        with pytest.raises(ResultFileError, match=what) as caught:
            read_result(path)
        assert str(path) in str(caught.value) and isinstance(caught.value, OSError)

    says(tmp_path / "absent.h5", "no such file")
    says(tmp_path, "this is a folder")
    content = stored.read_bytes()
    for name, data, what in (
        ("empty.h5", b"", "the file is empty"), ("text.h5", b"title = 'x'\n" * 10, "not an HDF5 file"),
        ("half.h5", content[: len(content) // 2], "truncated"), ("short.h5", content[:4], "not an HDF5 file")):
        (tmp_path / name).write_bytes(data)
        says(tmp_path / name, what)
    with h5py.File(tmp_path / "foreign.h5", "w") as file:
        file["x"] = [1.0]
    says(tmp_path / "foreign.h5", "not a thermoroll result")
    shutil.copy(stored, tmp_path / "newer.h5")
    with h5py.File(tmp_path / "newer.h5", "r+") as file:
        file.attrs["format_version"] = 99
    says(tmp_path / "newer.h5", r"result format 99, written by thermoroll .*; this version reads format 4 only: make it again")
    shutil.copy(stored, tmp_path / "holed.h5")
    with h5py.File(tmp_path / "holed.h5", "r+") as file:
        del file["numbers"]
    says(tmp_path / "holed.h5", "damaged")
    shutil.copy(stored, tmp_path / "flat.h5")
    with h5py.File(tmp_path / "flat.h5", "r+") as file:
        file["fields/x"][...] = 0.0
    says(tmp_path / "flat.h5", "its coordinates do not increase")
    os.mkfifo(tmp_path / "pipe")
    says(tmp_path / "pipe", "not a regular file")


def test_damage_anywhere_is_an_error_message_or_harmless(tmp_path: pathlib.Path, stored: pathlib.Path) -> None:
    """A flipped bit is never read as true: every array and all that says where it lies has a checksum."""
    content, path, dice, messages = stored.read_bytes(), tmp_path / "damaged.h5", random.Random(1), 0
    whole = contents(load(stored, "result"))
    for number in range(40):
        damaged = bytearray(content)
        for _ in range(1 if number < 30 else dice.choice([3, 20])):
            damaged[dice.randrange(len(damaged))] ^= 1 << dice.randrange(8)
        path.write_bytes(damaged if number % 8 else damaged[: dice.randrange(len(damaged))])
        try:
            assert contents(load(path, "result")) == whole
        except ResultFileError as error:
            assert str(path) in str(error)
            messages += 1
    assert messages > 22


def contents(node: Node) -> dict[str, object]:
    """All that a tree holds, as it can be compared."""
    values = {name: array.values for name, array in node.arrays.items()}
    return {"attributes": dict(node.attributes), "nodes": {name: contents(inner) for name, inner in node.nodes.items()},
            **{f"array {name}": (array.axes, array.units, array.meaning, values[name].shape,
                                 values[name].tolist() if values[name].dtype == object else values[name].tobytes())
               for name, array in node.arrays.items()}}


@pytest.mark.parametrize(("name", "value"), [("work", "[1, 2]"), ("warnings", "[1]"), ("patches", '[["a"]]'), ("status", "zz"),
                                             ("unbounded", "{"), ("record", "3.5")])  # fmt: skip
def test_attributes_of_another_kind_are_refused(tmp_path: pathlib.Path, stored: pathlib.Path, name: str, value: str) -> None:
    path = tmp_path / "made.h5"
    shutil.copy(stored, path)
    with h5py.File(path, "r+") as file:
        file.attrs[name] = np.bytes_(value)
    with pytest.raises(ResultFileError, match="damaged result file"):
        read_result(path)


@pytest.mark.parametrize("values", [np.array([b"a", b"b"]), np.array([1.0]), np.array([], dtype="S1")])
def test_a_text_that_is_none_is_refused(tmp_path: pathlib.Path, stored: pathlib.Path, values: np.ndarray) -> None:
    path = tmp_path / "made.h5"
    shutil.copy(stored, path)
    with h5py.File(path, "r+") as file:
        texts = file["input"]
        del texts["case_text"]
        for name, content in (("part_2", np.arange(len(values))), ("case_text", values)):
            texts[name] = content
            texts[name].attrs["axes"] = np.bytes_("part_2")
    with pytest.raises(ResultFileError, match="case_text is not one text"):
        read_result(path)


@pytest.mark.parametrize(("kind", "words"), [
    ("external link", "/fields/pressure is a link"), ("soft link", "/fields/pressure is a link"),
    ("hard link", "has two names"), ("external storage", "/fields/pressure lies in another file"),
    ("virtual", "/fields/pressure lies in another file"), ("complex", "holds neither numbers nor texts"),
    ("compound", "holds neither numbers nor texts"), ("references", "holds neither numbers nor texts"),
    ("variable text", "holds neither numbers nor texts"), ("group", "no numbers over|'pressure'|axes"),
    ("large", "which the file has not"), ("compressed", "which the file has not"), ("shape", "not that of its axes"),
    ("text", "holds no numbers over x and y"), ("attribute", "neither a number nor a text"),
    ("infinite", "its coordinates do not increase"),
])  # fmt: skip
def test_what_no_file_of_ours_has_is_refused(tmp_path: pathlib.Path, stored: pathlib.Path, kind: str, words: str) -> None:
    """Files by other hands name other files, or claim what would fill the memory. Nothing is read before all is checked."""
    path = tmp_path / "made.h5"
    shutil.copy(stored, path)
    with h5py.File(path, "r+") as file:
        fields = file["fields"]
        if kind == "infinite":
            fields["x"][-1] = np.inf
        elif kind == "attribute":
            fields.attrs["plane"] = [1.0, 2.0]
        else:
            values = fields["pressure"][()]
            (tmp_path / "secret").write_bytes(bytes(values.nbytes))
            del fields["pressure"]
            stored_as: dict[str, Any] = {
                "external link": h5py.ExternalLink(str(stored), "/fields/pressure"), "soft link": h5py.SoftLink("/fields/gap"),
                "hard link": fields["gap"], "complex": values + 1j, "variable text": "text", "shape": values[:-1],
                "compound": np.zeros(values.shape, dtype=[("a", "f8"), ("b", "i4")]), "text": np.full(values.shape, b"text")}
            made: dict[str, dict[str, Any]] = {
                "external storage": {"shape": values.shape, "dtype": "f8", "external": [(str(tmp_path / "secret"), 0,
                                                                                         values.nbytes)]},
                "references": {"shape": (2,), "dtype": h5py.ref_dtype},
                "large": {"shape": (2_000_000_000,), "dtype": "f8", "chunks": (1000,), "fillvalue": 1.0},
                "compressed": {"data": np.zeros((2000, 2000)), "compression": "gzip", "compression_opts": 9}}
            if kind in stored_as:
                fields["pressure"] = stored_as[kind]
            elif kind in made:
                fields.create_dataset("pressure", **made[kind])
            elif kind == "virtual":
                layout = h5py.VirtualLayout(values.shape, "f8")
                layout[...] = h5py.VirtualSource(str(stored), "fields/pressure", values.shape)
                fields.create_virtual_dataset("pressure", layout)
            else:
                fields.create_group("pressure")
            if "link" not in kind and kind != "group":
                fields["pressure"].attrs["axes"] = np.bytes_("x y")
    if kind == "group":
        assert "pressure" not in read_result(path).fields
        return
    with pytest.raises(ResultFileError, match=words):
        read_result(path)
