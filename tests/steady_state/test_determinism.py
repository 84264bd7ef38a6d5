"""The same case gives the same bits: in every process, with any number of threads."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.support.command_line import MECHANICAL, THERMAL, call, thermoroll
from tests.support.datasets import datasets

SPINNING = MECHANICAL.replace("longitudinal = 0.003", "longitudinal = 0.001\nlateral = 0.0005\nspin_rad_mm = 0.01")
HOT = THERMAL.replace("speed_m_s = 1.0", "speed_m_s = 100.0")
DISSIMILAR = SPINNING.replace(
    "[material]\nyoungs_modulus_GPa = 210.0\npoisson_ratio = 0.28",
    "[material.lower]\nyoungs_modulus_GPa = 210.0\npoisson_ratio = 0.28\n"
    "[material.upper]\nyoungs_modulus_GPa = 3.0\npoisson_ratio = 0.4",
)
CASES = {
    "dissimilar": DISSIMILAR,
    "forced": MECHANICAL.replace("[creepage]\nlongitudinal = 0.003", "[force]\nlongitudinal_N = 15.0"),
    "sliding": HOT + '[thermal]\npeclet = "sliding"\n',
    "stationary": HOT.replace("grid = 16", "grid = [24, 16]") + '[thermal]\npeclet = "stationary"\npartition = "matched"\n',
}


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """Result folders of two runs of the real command, with one thread and with two."""
    folder = tmp_path_factory.mktemp("runs")
    for name, text in CASES.items():
        (folder / f"{name}.toml").write_text(text)
    files = [f"{name}.toml" for name in CASES]
    for number, threads in enumerate(("1", "2")):
        # Texts are hashed with another seed in each process: nothing may depend on the order of a set.
        done = thermoroll("run", *files, "-o", f"{number}", "--threads", threads, "--no-plots", "-q", cwd=folder,
                          env={"PYTHONHASHSEED": str(number)})  # fmt: skip
        assert (done.returncode, done.stderr) == (0, "")
    return [folder / f"{number}" for number in range(2)]


@pytest.mark.parametrize("name", CASES)
def test_datasets_are_bit_identical_in_every_run_with_any_threads(name: str, runs: list[Path]) -> None:
    first, *others = (datasets(folder / f"{name}.h5") for folder in runs)
    assert len(first) > 10
    for other in others:
        assert other.keys() == first.keys()
        assert [key for key in first if other[key] != first[key]] == []


@pytest.mark.slow
def test_the_place_in_a_list_of_cases_does_not_matter(runs: list[Path]) -> None:
    folder = runs[0].parent
    assert call("run", "sliding.toml", "-o", "alone", "--no-plots", "-q", cwd=folder).returncode == 0
    assert datasets(folder / "alone" / "sliding.h5") == datasets(runs[0] / "sliding.h5")
