"""`validate`, `init`, `schema`, `show` through the real entry point: exit codes and streams."""

from __future__ import annotations

import dataclasses
import json
import os
import re
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.support.command_line import MECHANICAL, THERMAL, call, environment
from tests.support.sampling import sampled
from thermoroll_cli.cli.cases import EXAMPLES, TEMPLATES
from thermoroll_cli.files.case import Case, Override
from thermoroll_cli.problem.geometry import Geometry

CASES = Path(__file__).parents[2] / "cases"

MECHANICAL_TEMPLATES = ("twin-disc-wear", "locomotive")
OTHER_TEMPLATES = (*MECHANICAL_TEMPLATES, "wheelset", "bearing", "line-contact")


@pytest.fixture
def case(tmp_path: Path) -> Path:
    path = tmp_path / "two spheres.toml"
    path.write_text(THERMAL)
    return path


@pytest.fixture
def invalid(tmp_path: Path) -> Path:
    path = tmp_path / "bad.toml"
    path.write_text(MECHANICAL.replace("normal_N = 65.0", "normal_N = -65.0").replace("0.28", "0.6"))
    return path


def test_validate_says_valid_on_standard_output(case: Path) -> None:
    done = call("validate", case)
    assert (done.returncode, done.stdout, done.stderr) == (0, f"{case}: valid\n", "")
    assert call("validate", "-q", case).stdout == ""


def test_validate_tells_all_errors_of_all_cases(case: Path, invalid: Path, tmp_path: Path) -> None:
    done = call("validate", case, invalid, tmp_path / "none.toml")
    assert done.returncode == 3
    assert done.stdout == f"{case}: valid\n"
    assert f"{invalid}:4:17: error: material.poisson_ratio = 0.6" in done.stderr
    assert f"{invalid}:11:12: error: load.normal_N = -65.0" in done.stderr
    assert "none.toml: error: no such file" in done.stderr
    assert done.stderr.endswith("thermoroll: 3 errors\n")
    told = call("validate", "--json", case, invalid, tmp_path / "none.toml").stdout
    good, bad, none = map(json.loads, told.splitlines())
    assert good == {"case": str(case), "valid": True, "errors": [], "warnings": []} and not none["valid"]
    assert [(error["key"], error["line"]) for error in bad["errors"]] == [("material.poisson_ratio", 4), ("load.normal_N", 11)]


def test_validate_standard_input_and_overrides() -> None:
    assert call("validate", "-", stdin=MECHANICAL).returncode == 0
    done = call("validate", "-", "--set", "load.normal_N=-1", stdin=MECHANICAL)
    assert done.returncode == 3
    assert "--set load.normal_N=-1: error:" in done.stderr
    assert "<stdin>: error" in call("validate", "-", stdin="").stderr
    assert call("validate", "-", "--set", "load", stdin=MECHANICAL).returncode == 2


def test_error_of_an_override_is_told_once(case: Path, tmp_path: Path) -> None:
    (tmp_path / "other.toml").write_text(MECHANICAL)
    done = call("validate", case, tmp_path / "other.toml", "--set", "load.normal_N=-1")
    assert done.stderr.count("error: load.normal_N") == 1


def test_init_writes_a_valid_case(tmp_path: Path) -> None:
    done = call("init", "my case.toml", "--template", "line-contact", cwd=tmp_path)
    assert (done.returncode, done.stdout) == (0, "")
    assert "my case.toml" in done.stderr
    assert (tmp_path / "my case.toml").read_text().startswith("#")
    assert call("validate", tmp_path / "my case.toml").returncode == 0


def test_init_writes_the_cases_of_the_documents_with_their_files(tmp_path: Path) -> None:
    done = call("init", "--example", "manchester", cwd=tmp_path)
    assert done.returncode == 0 and "cases/manchester.toml" in done.stderr
    assert {path.name for path in (tmp_path / "cases").iterdir()} == {
        "manchester.toml", "MBench_S1002_v3.prw", "MBench_UIC60_v3.prr"}
    assert call("validate", "cases/manchester.toml", cwd=tmp_path).returncode == 0
    assert call("init", "--example", "manchester", cwd=tmp_path).returncode == 5
    assert call("init", "--example", "wheelset_wear", cwd=tmp_path).returncode == 0, "it reads the same profiles"
    (tmp_path / "cases" / "MBench_S1002_v3.prw").write_text("mine")
    (tmp_path / "cases" / "wheelset_wear.toml").unlink()
    assert "MBench_S1002_v3.prw exists" in call("init", "--example", "wheelset_wear", cwd=tmp_path).stderr
    assert call("init", "mine.toml", "--example", "wheel_rail", cwd=tmp_path).returncode == 0
    assert (tmp_path / "mine.toml").read_text() == (EXAMPLES / "wheel_rail.toml").read_text()
    assert call("init", "-", "--example", "table1").stdout == (EXAMPLES / "table1.toml").read_text()
    for both in (("--example", "table1", "--template", "roller"), ("--examples", "mine.toml")):
        assert call("init", *both, cwd=tmp_path).returncode == 2
    unknown = call("init", "--example", "nothing", cwd=tmp_path)
    assert unknown.returncode == 2 and "--examples lists them" in unknown.stderr
    listed = call("init", "--examples", cwd=tmp_path).stdout.splitlines()
    assert [line.split()[0] for line in listed] == sorted(path.stem for path in EXAMPLES.glob("*.toml"))
    assert "  manchester" in "".join(listed) and "Manchester benchmark, 4 mm" in "".join(listed)
    assert "did you mean manchester?" in call("init", "--example", "manchster", cwd=tmp_path).stderr


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="there are no named pipes")
def test_a_pipe_to_which_nobody_writes_is_not_waited_for(tmp_path: Path, case: Path) -> None:
    os.mkfifo(tmp_path / "profile.csv")
    case.write_text(re.sub("lower_radius_y_mm = .*", 'lower_profile = { file = "profile.csv" }', case.read_text()))
    done = call("validate", case)
    assert done.returncode == 3 and "two points at least, here are 0" in done.stderr


@pytest.mark.parametrize("template", [name for name in TEMPLATES if name not in OTHER_TEMPLATES])
def test_everything_a_template_offers_in_comments_works(template: str, tmp_path: Path) -> None:
    """What stands behind `# ` becomes part of the case, in place of what it says it replaces."""
    text = call("init", "-", "--template", template).stdout
    for wanted in ("[force]", "[material.upper]", "bulk_temperature_upper_K", "temperature_slope_1_K", '"matched"',
                   "[subsurface]", "[strength.upper]", "[wear.upper]",
                   *(["limit_coefficient", "[[material.upper.layers]]"] if "twin" not in template else []),
                   *(["[thermal.upper]"] if 'peclet = "rolling"' in text and "twin" not in template else [])):
        assert re.search(rf"^# .*{re.escape(wanted)}", text, re.MULTILINE), wanted
    offered = re.sub(r"^# (\w+ = |\[)", r"\1", text, flags=re.MULTILINE)
    offered = offered.replace("[material]\n", "[material.lower]\n")
    offered = re.sub(r"^(longitudinal|lateral) = .*\n|^partition = 0.5\n", "", offered, flags=re.MULTILINE)
    (tmp_path / "case.toml").write_text(offered)
    problem = Case.read(tmp_path / "case.toml").problem
    assert problem.subsurface is not None and problem.heating.recirculates == ('peclet = "rolling"' in text)
    assert problem.heating.conducts and problem.friction.slope > 0.0 and problem.lower != problem.upper
    assert problem.motion.force_x == pytest.approx(0.5 * problem.traction_limit, rel=1e-3)


@pytest.mark.parametrize("template", MECHANICAL_TEMPLATES)
def test_everything_a_mechanical_template_offers_in_comments_works(template: str, tmp_path: Path) -> None:
    offered = re.sub(r"^# (\w+ = |\[)", r"\1", call("init", "-", "--template", template).stdout, flags=re.MULTILINE)
    offered = re.sub(r"^(longitudinal = 0.006|limit_coefficient|half_slip_m_s|depth_um).*\n", "", offered, flags=re.MULTILINE)
    (tmp_path / "case.toml").write_text(offered.replace('law = "exponential"', 'law = "table"'))
    problem = Case.read(tmp_path / "case.toml").problem
    if template == "locomotive":
        assert problem.friction.law is not None and problem.friction.law.kind == "table" and problem.motion.force_x == 25000.0
    else:
        assert problem.wear is not None and problem.wear.distance == 50e3 and problem.wear.lower.rate > 0.0
    assert problem.subsurface is not None and problem.subsurface.upper_strength is not None and problem.wear is not None


def test_the_sweep_that_the_locomotive_is_made_for_has_no_warnings() -> None:
    case = call("init", "-", "--template", "locomotive").stdout
    for creepage in ("1e-4", "0.006", "0.1"):
        assert call("validate", "-", "--set", f"creepage.longitudinal={creepage}", stdin=case).stderr == ""


def test_init_defaults_and_refuses_to_overwrite(tmp_path: Path) -> None:
    assert call("init", "-q", cwd=tmp_path).stderr == ""
    written = (tmp_path / "case.toml").read_text()
    # A case that exists: nothing rolls at the 200 m/s of the article's template.
    assert tomllib.loads(written)["title"] == "Wheel on rail" and tomllib.loads(written)["thermal"]["peclet"] == "rolling"
    (tmp_path / "case.toml").write_text("mine")
    done = call("init", cwd=tmp_path)
    assert done.returncode == 5
    assert "--force" in done.stderr
    assert (tmp_path / "case.toml").read_text() == "mine"
    assert call("init", "--force", cwd=tmp_path).returncode == 0
    assert (tmp_path / "case.toml").read_text() == written
    (tmp_path / "folder").mkdir()
    assert "give the name of the case file" in call("init", "folder", "--force", cwd=tmp_path).stderr
    assert call("init", "no/such/folder.toml", cwd=tmp_path).returncode == 5
    wrong = call("init", "--template", "nothing", cwd=tmp_path)
    assert wrong.returncode == 2 and all(f"'{name}'" in wrong.stderr for name in TEMPLATES)
    shown = [line.strip() for line in call("init", "--help").stdout.splitlines()]
    assert all(f"{name}: {about}" in shown for name, about in TEMPLATES.items())


def test_schema_knows_every_key_unit_and_exclusion() -> None:
    done = call("schema")
    assert (done.returncode, done.stderr) == (0, "")
    schema = json.loads(done.stdout)
    tables = schema["$defs"]
    assert tables["Load"]["properties"]["normal_N"]["unit"] == "N"
    assert tables["Load"]["additionalProperties"] is False
    assert sorted(schema["required"]) == ["load", "material"]  # and rolling, but for bearings
    # Infinite radii, which have no other form in JSON; TOML has no null. Rollers are left out where rails are straight.
    assert done.stdout.count("null") == sum(
        "radius" in key and not key.startswith("roller_")
        for name in ("Geometry", "Track") for key in tables[name]["properties"])
    for table in tables.values():
        assert all("description" in entry or "$ref" in entry for entry in table["properties"].values())


def test_show_has_inputs_numbers_and_plan(case: Path) -> None:
    done = call("show", case)
    assert (done.returncode, done.stderr) == (0, "")
    for wanted in ("2.1e+11", "hertz_a_mm", "peclet_lower", "saturation_creepage", "skipped: ", "grid 16×16", "MiB"):
        assert wanted in done.stdout


def test_show_json(case: Path) -> None:
    done = call("show", case, "--json", "--set", "rolling.speed_m_s=2")
    (line,) = done.stdout.splitlines()
    shown: dict[str, Any] = json.loads(line)
    assert shown["inputs"]["rolling.speed_m_s"] == {"value": 2.0, "si": 2.0, "unit": "m/s"}
    assert shown["inputs"]["geometry.lower_radius_x_mm"] == {"value": 30.0, "si": 0.03, "unit": "m"}
    assert shown["grid"] == [16, 16]
    assert shown["hertz_a_mm"] == pytest.approx(0.1858, rel=1e-3)
    assert set(shown["skipped"]) | set(shown["run"]) >= {"tangential", "heat", "deformation"}


def numbers(part: Any) -> Iterator[float]:
    """All numbers in a problem in SI units, however deep."""
    for field in dataclasses.fields(part):
        value = getattr(part, field.name)
        if dataclasses.is_dataclass(value):
            yield from numbers(value)
        elif isinstance(value, tuple) and value and dataclasses.is_dataclass(value[0]):
            for item in value:
                yield from numbers(item)
        elif isinstance(value, int | float) and not isinstance(value, bool):
            yield value


@pytest.mark.parametrize("name", sampled((path.name for path in sorted(CASES.glob("*.toml"))
    if not re.search(r"^\[(wheelset|bearing|history)\]", path.read_text(), re.MULTILINE)), 3))  # fmt: skip
def test_show_has_case_keys_with_the_si_values_that_are_solved(name: str) -> None:
    case = Case.read(CASES / name)
    solved = {*numbers(case.problem), *(case.problem.numerics.grid or ())}
    for item in case.inputs:
        Override.parse(f"{item.key}=1")
        # Without a law of slip its defaults enter nothing; with one coefficients are shares of that at rest.
        slip_law = item.key.startswith("friction.") and not item.key.startswith("friction.temperature_")
        shares = slip_law and (case.problem.friction.law is None or item.key == "friction.limit_coefficient")
        # The radii of a conformal contact have become tables of its common surface.
        tables = item.key.startswith("geometry.") and not isinstance(case.problem.geometry, Geometry)
        assert shares or tables or item.si is None or item.si in solved, item.key
        section, _, key = item.key.partition(".")
        assert section in tomllib.loads(case.to_toml())
        assert key or section == "title"


def test_show_fits_eighty_columns(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    lines = call("show", CASES / "wheel_rail.toml", "--set", "load.normal_N=1e9").stdout.splitlines()
    assert max(map(len, lines)) <= 80
    assert any(line.startswith("  warning: ") for line in lines)
    assert "motion." not in "\n".join(lines)


def test_the_time_of_pictures_is_part_of_the_estimate(case: Path) -> None:
    def seconds(*options: str) -> float:
        return float(json.loads(call("show", case, "--json", *options).stdout)["picture_seconds"])

    assert seconds("--set", "output.plots=false") == 0.0
    assert 0.0 < seconds("--set", "thermal.heat=false") < seconds()
    assert "s of them for pictures" in call("show", case).stdout


@pytest.mark.slow
@pytest.mark.skipif(not os.path.exists("/proc/self/status"), reason="needs the kernel's count of memory")
def test_the_memory_is_that_of_the_process_and_a_bound_says_so(case: Path, tmp_path: Path) -> None:
    """Within a quarter of what the kernel counts for a run of its own."""
    sets = ("--set", "numerics.grid=96", "--set", "output.plots=false")
    shown = json.loads(call("show", case, "--json", *sets).stdout)
    arguments = ["run", str(case), "-q", "-o", str(tmp_path), *sets]
    program = (f"from thermoroll_cli.cli.main import main; main({arguments!r}); "
               "print(*(line for line in open('/proc/self/status') if line.startswith('VmHWM')))")  # fmt: skip
    done = subprocess.run([sys.executable, "-c", program], env=environment({}), capture_output=True, text=True, check=True)
    kibibytes = int(done.stdout.split()[-2])
    assert shown["memory_bytes"] == pytest.approx(1024 * kibibytes, rel=0.25)
    assert shown["upper_bound"] is False and "at most about" not in call("show", case, *sets).stdout
    assert "at most about" in call("show", case, "--set", "numerics.accuracy=1e-2").stdout


def test_a_problem_that_the_plan_refuses_is_an_invalid_case(tmp_path: Path) -> None:
    """A profile, whose contact only the plan knows: the same error of every command, at the key."""
    path = tmp_path / "narrow.toml"
    path.write_text(THERMAL.replace("upper_radius_y_mm = 30.0\n", "") + "[thermal]\npartition = 'matched'\n"
                    "[thermal.upper]\nrecirculate = true\nthermal_resistance_K_W = 4.0\nwidth_mm = 0.1\n"
                    "[geometry.upper_profile]\npoints_mm = [[-2, -0.1], [-1, 0], [1, 0], [2, -0.1]]\n")  # fmt: skip
    for command in (["validate"], ["show"], ["run", "-o", str(tmp_path), "--no-plots"]):
        done = call(*command, path)
        assert done.returncode == 3, done.stderr
        assert "26:12: error: thermal.upper.width_mm = 0.1: a width of 0.1 mm is below that of the contact" in done.stderr
        (record,) = (json.loads(line) for line in call(*command, path, "--json").stdout.splitlines())
        assert [error["line"] for error in record["errors"]] == [26] and record["valid"] is False


def test_a_result_is_a_case_to_every_command(case: Path, tmp_path: Path) -> None:
    assert call("run", case, "--no-plots", "-q", "-o", tmp_path).returncode == 0
    result = tmp_path / f"{case.stem}.h5"
    assert call("show", result, "--json").stdout == call("show", case, "--json").stdout
    assert call("validate", result).stdout.splitlines() == [f"{result}: valid"]
    assert json.loads(call("wear", result, "--set", "load.normal_N=-1", "--json").stdout)["valid"] is False
    sweep = ("sweep", result, "--over", "load.normal_N=50,60", "--no-plots", "--json", "-o", tmp_path)
    assert [json.loads(line)["name"] for line in call(*sweep).stdout.splitlines()] == [f"{case.stem}_000{n}" for n in (1, 2)]
    assert "load.normal_N = -1" in call("validate", result, "--set", "load.normal_N=-1").stderr


def test_constants_of_both_bodies_and_a_coating_of_one(case: Path, tmp_path: Path) -> None:
    coating = '[[material.upper.layers]]\nthickness_um = 3.0\nyoungs_modulus_GPa = 280.0\npoisson_ratio = 0.21\n'
    problem = Case.parse(MECHANICAL.replace("[geometry]", coating + "[geometry]")).problem
    assert len(problem.upper.layers) == 1 and problem.lower == dataclasses.replace(problem.upper, layers=())


def test_what_is_allowed_and_doubtful_is_told_everywhere(case: Path, tmp_path: Path) -> None:
    settings, words = [f"thermal.bulk_temperature_{body}_K=9" for body in ("lower", "upper")], "temperatures have no effect"
    options = [word for setting in (*settings, "thermal.heat=false", "numerics.grid=8") for word in ("--set", setting)]
    checked = call("validate", case, *options)
    assert (checked.returncode, checked.stdout) == (0, f"{case}: valid\n")
    assert f"{case}: warning: " in checked.stderr and words in checked.stderr
    assert any(words in warning for warning in json.loads(call("validate", case, *options, "--json").stdout)["warnings"])
    assert words in " ".join(call("show", case, *options).stdout.split())
    solved = json.loads(call("run", case, *options, "--json", "--no-plots", "-q", "-o", tmp_path / "out").stdout)
    assert any(words in warning for warning in solved["warnings"])
    assert call("validate", case, *options, "-q").stderr == ""


def test_temperatures_no_solid_stands_are_expected_and_then_found(case: Path, tmp_path: Path) -> None:
    options = ("--set", "rolling.speed_m_s=2e5", "--set", "thermal.deformation=false", "--set", "creepage.longitudinal=0.05")
    assert "expected to get about" in call("validate", case, *options).stderr
    done = call("run", case, *options, "--json", "--no-plots", "-q", "-o", tmp_path / "out")
    (warning,) = json.loads(done.stdout)["warnings"]
    assert warning.startswith("temperature rises by up to ") and "2000 K" in warning
    assert "expected" not in done.stdout


@pytest.mark.slow
def test_shipped_cases_and_templates_are_beyond_doubt() -> None:
    # The discs of a measurement have edges, and heat spreads beyond their width: their case is warned of.
    done = call("validate", *sorted(case for case in CASES.glob("*.toml") if case.stem != "twin_disc_lewis"))
    assert (done.returncode, done.stderr) == (0, "")
    for template in TEMPLATES:
        done = call("validate", "-", stdin=call("init", "-", "--template", template).stdout)
        assert (done.returncode, done.stderr) == (0, "")
