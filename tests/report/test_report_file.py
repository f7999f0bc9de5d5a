"""The file of a report: sound HTML that needs nothing but itself, and the command that writes it."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
from pathlib import Path

import pytest
from support.paths import ROOT
from support.report_pages import NASTY, parsed, section, words
from typer.testing import CliRunner

from wroll_fem import cli
from wroll_fem.jobs.folder import RunFolder
from wroll_fem.report import write_report

CONFIGS = sorted((ROOT / "configs").glob("*.yaml"))


def test_nothing_is_fetched_and_nothing_runs(run_file: Path, batch_file: Path) -> None:
    for file in (run_file, batch_file):
        root = parsed(file)
        ids = [element.get("id") for element in root.iter() if element.get("id")]
        assert len(ids) == len(set(ids))
        tags = {element.tag for element in root.iter()}
        assert not tags & {"script", "link", "iframe", "object", "embed", "base", "form", "video", "audio"}
        for element in root.iter():
            for name, value in element.attrib.items():
                assert not name.startswith("on")
                if name in ("src", "srcset"):
                    assert value.startswith("data:image/png;base64,")
                elif name == "href":
                    assert value.removeprefix("#") in ids
                else:
                    assert "://" not in value
        style = root.findtext("head/style") or ""
        assert style
        assert not re.search(r"url\(|@import|://", style)
        policy = next(m for m in root.iter("meta") if m.get("http-equiv") == "Content-Security-Policy")
        assert policy.get("content", "").startswith("default-src 'none'")


def test_a_screen_reader_and_a_printer_find_their_way(run_file: Path, batch_file: Path) -> None:
    for written in (run_file, batch_file):
        root = parsed(written)
        assert root.get("lang") == "en"
        assert root.findtext("head/title") == root.findtext("body/main/h1")
        assert [e.tag for e in root.iter() if e.tag in ("h1", "h2")].count("h1") == 1
        assert root.find("body/main/nav").get("aria-label")  # type: ignore[union-attr]
        tables = list(root.iter("table"))
        assert tables
        for table in tables:
            width = len(table.findall("thead/tr/th"))
            assert all(th.get("scope") == "col" and words(th) for th in table.iter("th"))
            assert all(len(row) == width for row in table.findall("tbody/tr"))
            for row in table.findall("tbody/tr"):  # heads stand over their numbers
                assert all(
                    th.get("class") == "n" for th, td in zip(table.iter("th"), row, strict=True) if td.get("class")
                )
        assert all(e.get("tabindex") == "0" for e in root.iter("div") if e.get("class") == "wide")
        captions = [words(figure.find("figcaption")) for figure in root.iter("figure")]  # type: ignore[arg-type]
        assert [image.get("alt") for image in root.iter("img")] == captions
        assert all(captions)
        paper = (root.findtext("head/style") or "").partition("@media print")[2]
        assert "overflow: visible" in paper
        assert "nav { display: none; }" in paper


def test_every_text_is_escaped(run: RunFolder, tmp_path: Path) -> None:
    folder = RunFolder(tmp_path / "<b>bold & brave<")
    shutil.copytree(run.path, folder.path)
    folder.case_file.write_text(f"# {NASTY}\n{run.case_file.read_text()}")
    folder.log_file.write_text(f"now warning: {NASTY}\n")
    folder.write_json(folder.provenance_file, {**run.provenance(), "command": NASTY, "versions": {NASTY: NASTY}})
    folder.write_json(folder.summary_file, {NASTY: NASTY, "zeta": None, "list": [NASTY]})
    shutil.copy(run.figures / "transmissibility.png", folder.figures / "<i>&'.png")
    root = parsed(write_report(folder.path))
    assert not {"script", "b", "i"} & {element.tag for element in root.iter()}
    assert root.findtext("body/main/h1") == "Run <b>bold & brave<"
    for heading in ("What was solved", "Warnings", "Metrics", "Versions and provenance"):
        assert "<script>alert('1')</script> & \"quoted\"" in words(section(root, heading))
    assert "none" in words(section(root, "Metrics"))


@pytest.mark.parametrize(
    "text",
    ["a: 2001-99-99", "a: !!bool maybe", "[" * 3000, "mandrel: 5", "geometry: [1, {a: 2}]", "- 1", "1: {2: 3}",
     "null: [{3: 4}]", "excitation: {kind: [1]}", "analysis: {a: 1}"],
)  # fmt: skip
def test_a_report_shows_a_case_file_of_any_content_as_written(text: str, run: RunFolder, tmp_path: Path) -> None:
    folder = RunFolder(tmp_path / "odd")
    shutil.copytree(run.path, folder.path)
    folder.case_file.write_text(text)
    assert text in words(section(parsed(write_report(folder.path)), "What was solved"))


@pytest.mark.parametrize("entry", ["git", "versions", "machine", "seeds", "exit_code", "status"])
def test_a_report_leaves_out_an_origin_of_another_type(entry: str, run: RunFolder, tmp_path: Path) -> None:
    folder = RunFolder(tmp_path / "odd")
    shutil.copytree(run.path, folder.path)
    folder.write_json(folder.provenance_file, {**run.provenance(), entry: ["odd", 1]})
    assert "odd" not in words(section(parsed(write_report(folder.path)), "Versions and provenance"))


def test_broken_folders_are_refused_in_one_line(run: RunFolder, tmp_path: Path) -> None:
    (tmp_path / "batch.csv").write_text("a,b\n1,2\n")
    empty = tmp_path / "empty"
    empty.mkdir()
    for arguments, told in (
        ([empty], "neither the folder of a run"),
        ([tmp_path / "missing"], "is not a folder"),
        ([tmp_path], "is not the table of a batch"),
        ([run.path, "--out", empty], "cannot be written"),
    ):
        result = CliRunner().invoke(cli.app, ["report", *map(str, arguments)])
        assert result.exit_code == 2
        assert told in result.output
        assert len(result.output.strip().splitlines()) == 1
    assert list(empty.iterdir()) == []


def test_command_prints_the_file_it_wrote(run: RunFolder, tmp_path: Path) -> None:
    target = tmp_path / "deep" / "out.html"
    result = CliRunner().invoke(cli.app, ["report", str(run.path), "--out", str(target)])
    assert (result.exit_code, result.output.strip()) == (0, str(target))
    assert parsed(target).findtext("head/title") == "Run a run"
    assert [p.name for p in target.parent.iterdir()] == ["out.html"]


CHECK = """<script>
window.addEventListener("load", () => {
  const images = [...document.images];
  const found = {images: images.length, drawn: images.filter(i => i.complete && i.naturalWidth > 300).length,
    wide: document.documentElement.scrollWidth, window: window.innerWidth,
    tables: document.querySelectorAll("table tbody tr").length,
    heading: document.querySelector("h1").getBoundingClientRect().height};
  document.body.setAttribute("data-found", JSON.stringify(found));
});
</script></body>"""


BROWSER = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "chromium-headless-shell"))), None)


@pytest.mark.skipif(BROWSER is None, reason="no browser: `apt-get install chromium-headless-shell` to open the report")
@pytest.mark.parametrize("width", [pytest.param(1200, marks=pytest.mark.slow), 700])
def test_a_browser_shows_the_report(
    run: RunFolder, batch: Path, run_file: Path, batch_file: Path, tmp_path: Path, width: int
) -> None:
    assert BROWSER is not None
    for folder, written in ((run.path, run_file), (batch, batch_file)):
        file = tmp_path / "r.html"
        text = written.read_text(encoding="utf-8")
        policy = re.search(r"<meta http-equiv=\"Content-Security-Policy\"[^>]*>", text)
        assert policy is not None  # taken out of the copy alone: it would stop the check's own script
        file.write_text(text.replace(policy[0], "").replace("</body>", CHECK), encoding="utf-8")
        command = [
            BROWSER, "--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--no-first-run",
            f"--user-data-dir={tmp_path / 'profile'}", f"--window-size={width},900", "--virtual-time-budget=10000",
            "--dump-dom", file.as_uri(),
        ]  # fmt: skip
        done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=False)
        held = re.search(r'data-found="([^"]*)"', done.stdout)
        assert held is not None, done.stderr[-2000:]
        found = json.loads(held[1].replace("&quot;", '"'))
        assert found["images"] == found["drawn"] == len(list((folder / "figures").glob("*.png")))
        assert found["wide"] <= found["window"]  # tables and code scroll by themselves
        assert found["tables"] > 3
        assert found["heading"] > 10
