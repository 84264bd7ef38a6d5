"""`report` and `--report`: one HTML file with everything, which needs nothing else."""

from __future__ import annotations

import base64
import html
import re
import tomllib
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import pytest

from tests.support import synthetic
from tests.support.browser import opened
from tests.support.command_line import MECHANICAL, THERMAL, call
from thermoroll_cli import Case, solve
from thermoroll_cli.cli import report
from thermoroll_cli.cli.tables import headed
from thermoroll_cli.files.result.outcome import read_result
from thermoroll_cli.problem.result import Result

HOSTILE = "<script>alert('a & b')</script> {{ 7 * 7 }}"


class Page(HTMLParser):
    """The elements of a page with their attributes, and its text."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.elements: list[tuple[str, dict[str, str | None]]] = []
        self.words: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.elements.append((tag, dict(attrs)))

    def handle_data(self, data: str) -> None:
        self.words.append(data)

    @property
    def text(self) -> str:
        return " ".join(" ".join(self.words).split())


def read(path: Path) -> Page:
    page = Page(path.read_text(encoding="utf-8"))
    tags = {tag for tag, _ in page.elements}
    assert not tags & {"script", "link", "iframe", "object", "embed"}
    addresses = [value for _, attributes in page.elements for name, value in attributes.items() if name in ("src", "href")]
    assert all(str(address).startswith("data:image/") for address in addresses)
    assert not any(name.startswith("on") for _, attributes in page.elements for name in attributes)
    return page


def case(text: str, folder: Path, name: str = "a") -> Path:
    path = folder / f"{name}.toml"
    path.write_text(text, encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A case with heat and an unkind title, its result and its report."""
    folder = tmp_path_factory.mktemp("report")
    text = re.sub(r"(?m)^title = .*\n", "", THERMAL)
    case(f'title = "{HOSTILE}"\n{text}', folder)
    done = call("run", "a.toml", "--no-plots", "--report", "-o", ".", cwd=folder)
    assert done.returncode == 0 and "wrote a.h5, a_report.html" in done.stdout
    return folder


@pytest.mark.slow
def test_a_report_says_what_the_result_says(folder: Path) -> None:
    page, result = read(folder / "a_report.html"), read_result(folder / "a.h5")
    assert ("img", {}) not in page.elements and sum(tag == "img" for tag, _ in page.elements) >= 4
    text = page.text
    assert "± is the estimated error" in text and "total frictional heat" in text
    shown = re.search(r"maximum pressure ([\d.]+) ± ([\d.]+)", text)
    assert shown is not None and float(shown[1]) == pytest.approx(result["pressure_max_MPa"], abs=float(shown[2]))
    assert f"thermoroll {result.attributes['program_version']}, Python" in text
    for line in filter(None, result.case_text.splitlines()):
        assert " ".join(line.split()) in text


def test_words_of_a_case_stay_words(folder: Path) -> None:
    source = (folder / "a_report.html").read_text(encoding="utf-8")
    assert HOSTILE not in source and "<script" not in source
    assert source.count(html.escape(HOSTILE).replace("&#x27;", "&#39;")) >= 3
    (title,) = re.findall("<title>(.*)</title>", source)
    assert html.unescape(title) == HOSTILE


@pytest.fixture
def without_pictures(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where words are what matters."""
    monkeypatch.setattr(report, "pictures_of", lambda draw_in: ())


@pytest.mark.usefixtures("without_pictures")
def test_run_and_report_write_the_same(folder: Path, tmp_path: Path) -> None:
    done = call("report", folder / "a.h5", "-o", tmp_path / "other.html")
    assert (done.returncode, done.stdout) == (0, f"{tmp_path / 'other.html'}\n")
    here, there = (read(path).text for path in (tmp_path / "other.html", folder / "a_report.html"))
    (pictures,) = re.findall(r"Pictures .*?(?=Case The case file)", there)
    assert here == there.replace(pictures, "")


def test_pictures_are_whole(folder: Path) -> None:
    for address in re.findall(r'src="data:image/([^"]*)"', (folder / "a_report.html").read_text(encoding="utf-8")):
        kind, _, content = address.partition(";base64,")
        begin = base64.b64decode(content)[:5]
        assert begin == {"png": b"\x89PNG\r", "svg+xml": b"<?xml"}[kind]


def written(result: Result, path: Path) -> Page:
    result.save(path)
    assert call("report", path, "-q").returncode == 0
    return read(path.with_name(f"{path.stem}_report.html"))


@pytest.mark.usefixtures("without_pictures")
def test_failures_and_warnings_come_first(folder: Path, tmp_path: Path) -> None:
    failed = replace(read_result(folder / "a.h5"), converged=False, reason="no <steady> state", warnings=("half & half",))
    text = written(failed, tmp_path / "f.h5").text
    expected = ("Not converged. no <steady> state", "Warning. half & half", "total frictional heat")
    places = [text.index(words) for words in expected]
    assert places == sorted(places)


@pytest.mark.usefixtures("without_pictures")
def test_numbers_that_are_not_there_are_left_out(tmp_path: Path) -> None:
    """A result without fields of heat, or any estimate, and without a case."""
    text = written(synthetic.result(heat=False), tmp_path / "m.h5").text
    assert "temperature" not in text.partition("Method")[0] and "The case file" not in text and " nan" not in text


@pytest.mark.slow
def test_a_line_contact_shows_each_curve_once() -> None:
    case = tomllib.loads(call("init", "--template", "line-contact", "-").stdout)
    case["numerics"] = {"grid": 32}
    section = report.of_result(solve(Case.from_dict(case)), "")
    assert [picture.name for picture in section.pictures] == ["centreline"]


def test_a_bearing_has_a_table_of_its_balls(monkeypatch: pytest.MonkeyPatch) -> None:
    """With the names of its columns; its contacts lie on rings, not on rails."""
    monkeypatch.setattr(report, "pictures_of", lambda draw: ())
    case = tomllib.loads(call("init", "--template", "bearing", "-").stdout)
    case["bearing"] |= {"control": "outer", "balls": 3}
    case["numerics"] = {"grid": 8}
    section = report.of_result(solve(Case.from_dict(case)), "")
    _, balls, contacts = section.tables
    assert list(balls.header[:4]) == ["ball", "ring", "normal_N", "contact_angle_deg"]
    assert [row[:2] for row in balls.rows] == [("1, 2, 3", "inner"), ("1, 2, 3", "outer")]
    hottest = [row[list(balls.header).index("temperature_rise_max_lower_K")] for row in balls.rows]
    assert all(float(text.partition("±")[0]) > 0.01 for text in hottest)
    printed = headed([balls.header, *balls.rows])
    assert "temperature_" in printed[0] and "lower_K" in printed[-3] and max(map(len, printed)) < 110
    words = {row[-1]: row[0] for row in contacts.rows}
    assert (words["normal_N"], words["contact_angle_deg"]) == ("normal force", "contact angle")


def test_sweeps(tmp_path: Path) -> None:
    """Keys in the header break between their words, and not inside."""
    case(MECHANICAL, tmp_path)
    keys = ("--over", "creepage.longitudinal=0.001,0.002,0.003", "--over", "creepage.spin_rad_mm=0")
    done = call("sweep", "a.toml", *keys, "--report", "--no-plots", "-o", ".", "--scalars-only", cwd=tmp_path)
    assert done.returncode == 0 and "sweep_report.html" in done.stdout
    page, text = read(tmp_path / "sweep_report.html"), (tmp_path / "sweep_report.html").read_text(encoding="utf-8")
    assert "A sweep over creepage.longitudinal with 3 values" in page.text and "3 of 3 points converged." in page.text
    assert "<th>creepage.<wbr>spin_<wbr>rad_<wbr>mm</th>" in text and not re.search(r"\bth \{[^}]*anywhere", text)
    assert call("report", "sweep.h5", "sweep.h5", "-q", cwd=tmp_path).returncode == 0
    assert read(tmp_path / "report.html").text.count("A sweep over creepage.longitudinal with 3 values") == 2
    assert "normal_N = 65" in page.text and "poisson_ratio" in page.text and "thermoroll sweep a.toml" in page.text
    assert sum(tag == "tr" for tag, _ in page.elements) == 4 and sum(tag == "img" for tag, _ in page.elements) == 1


@pytest.mark.usefixtures("without_pictures")
def test_fits_and_wear(tmp_path: Path) -> None:
    case(MECHANICAL, tmp_path)
    (tmp_path / "d.csv").write_text("creepage.longitudinal,force_x_N\n0.001,8\n0.003,15\n0.02,18\n", encoding="utf-8")
    done = call("fit", "a.toml", "d.csv", "--free", "load.friction_coefficient=0.1:0.6", "--set", "numerics.grid=16",
                "--report", "--no-plots", "-q", "-o", ".", cwd=tmp_path)  # fmt: skip
    text = read(tmp_path / "a_fit_report.html").text
    assert done.returncode == 0 and re.search(r"load.friction_coefficient 0\.\d+ ± 0\.\d+", text) and "95 % interval" in text
    worn = Path(__file__).parents[2] / "cases" / "twin_disc_wear.toml"
    assert call("wear", worn, "--set", "numerics.grid=12", "--set", "wear.depth_um=1", "--no-plots", "--report", "-q", "-o",
                tmp_path).returncode == 0  # fmt: skip
    assert re.search(r"largest worn depth, lower body \d\S* µm", read(tmp_path / "twin_disc_wear_wear_report.html").text)


def test_a_report_opens_in_a_browser(folder: Path, tmp_path: Path) -> None:
    """Nothing is asked of a server, nothing is complained about, and it prints on a few sheets of A4."""
    printed = tmp_path / "a.pdf"
    found = opened((folder / "a_report.html").as_uri(), tmp_path, f"--print-to-pdf={printed}", "--no-pdf-header-footer")
    assert not found.console and not found.requests
    content = printed.read_bytes()
    assert 1 <= len(re.findall(rb"/Type\s*/Page\b", content)) <= 5
    assert re.search(rb"/MediaBox\s*\[0 0 59[45][\d.]* 84[12]", content)
