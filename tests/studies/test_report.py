"""The report, one page that says what failed, and the command line of the studies."""

import importlib
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from support.repository import ROOT
from support.scene_files import writer

from studies import MODULES, REPORTED, STUDIES, pull_off, report, template
from studies import __main__ as command_line
from studies import report as page
from studies.benchmarks import skipping
from studies.shared import table
from studies.shared.figures import canvas, save

ROWS = [
    skipping.Row("far field", 1e-4, 2e-4, 2.0, 1.9, 2.1, 1e-15),
    skipping.Row("fields", 1e-4, 5e-4, 5.0, 4.9, 5.1, 0.0),
]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    out = tmp_path_factory.mktemp("report")
    only = ["--only", "pull_off", "skipping"]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(skipping, "run", lambda p, show: ROWS)  # however busy the machine
        assert report.main(["--preset", "quick", *only, "--out", str(out)]) == 0
    return out


@pytest.mark.slow
def test_report_figures_and_links(folder):
    """Every figure is in the page and every link leads to a file beside it."""
    made = (folder / "report.html").read_text("utf-8")
    sources = re.findall(r"src=\"?([^\"> ]{0,30})", made)
    assert len(sources) == 2
    assert all(s.startswith("data:image/png;base64,") for s in sources)
    links = re.findall(r"href=\"([^\"]+)\"", made)
    assert len(links) >= 6
    assert not any("//" in link or link.startswith("/") for link in links)
    for link in links:
        if link.startswith("#"):
            assert f"<h2 id={link[1:]}>" in made
        else:
            assert (folder / link).is_file()
    assert {"pull_off/pull_off.csv", "skipping/skipping.csv"} < set(links)
    assert "<figcaption>Tension strengthens the adhesion of punch and parabola" in made
    assert "skipping/printed.txt" in links
    assert not (folder / "report.jsonl").exists()
    assert "answer: " in (folder / "skipping" / "printed.txt").read_text("utf-8")
    assert "<span class=good>All 2 studies passed.</span>" in made


@pytest.mark.slow
def test_a_failing_study_is_shown_and_counts(tmp_path, monkeypatch, capsys):
    command = ["--quick", "--only", "pull_off", "--out", str(tmp_path)]
    monkeypatch.setattr(pull_off, "BAR", 0.0)
    assert report.main(command) == 1
    made = (tmp_path / "report.html").read_text("utf-8")
    assert "<span class=bad>1 of 1 studies failed</span>: pull_off." in made
    assert made.count("<span class=bad>failed</span>") == 2  # in the contents and below
    assert "FAILED" in capsys.readouterr().out

    def broken(params, show, jobs):
        raise ValueError("depth = nan <is> wrong")

    monkeypatch.setattr(pull_off, "run", broken)
    assert report.main(command) == 1
    assert "depth = nan &lt;is&gt; wrong" in (tmp_path / "report.html").read_text("utf-8")


def test_the_verdict_agrees_with_the_studies():
    def one(name, printed="", status=0):
        return page.Section(name, "?", printed, status, Path(), 1.0)

    assert "All 1 studies passed." in page.verdict([one("a")])
    slow = one("slow", "text\nmissed: time\n")
    wrong = one("wrong", "missed: time\n", 1)
    assert "2 studies passed, but not all" in page.verdict([one("a"), slow])
    told = page.verdict([one("a"), slow, wrong])
    assert "1 of 3 studies failed</span>: wrong. Limits missed: slow." in told
    assert [x.verdict for x in (slow, wrong)] == ["passed, but missed 1 of its limits", "failed"]


def test_the_verification_table_shows_a_failure(tmp_path):
    (tmp_path / "verify.csv").write_text(
        "# command: x\nequation,what,error,order,fitted_error,passed\n"
        "16,line,1.234567e-9,2.01,3e-15,True\n8,<angle>,1e-2,exact,nan,False\n",
        "utf-8",
    )
    verify = page.Section("verify", "?", "", 1, tmp_path, 1.0)
    shown = page.page([verify], "a command", "facts")
    for cell in ("<td class=text>&lt;angle&gt;</td>", "<td>—</td>", "<td>1.235e-09</td>"):
        assert cell in shown
    rows = [re.findall(r"<td.*?>(.*?)</td>", row) for row in re.findall(r"<tr.*?</tr>", shown)]
    assert [row[:3] for row in rows if row] == [["8", "NO", "&lt;angle&gt;"], ["16", "yes", "line"]]
    assert shown.count("<tr class=bad>") == 1


def test_a_report_grows_and_goes_on_where_it_was_stopped(tmp_path, monkeypatch, capsys):
    """Stopped in the third study; the second has failed and is run again."""
    ran = []
    stop = ["sphere"]
    page_at = tmp_path / "report.html"

    def run(name, preset, out, jobs):
        if ran and stop:
            assert f"<h2 id={ran[-1]}>" in page_at.read_text("utf-8")  # before the next begins
        if name in stop:
            raise KeyboardInterrupt
        ran.append(name)
        return page.Section(name, "?", f"answer: {name}\n", int(name == "verify"), out / name, 1.5)

    monkeypatch.setattr(report, "run", run)
    command = ["--quick", "--only", "layer", "verify", "sphere", "--out", str(tmp_path)]
    with pytest.raises(KeyboardInterrupt):
        report.main(command)
    assert ran == ["layer", "verify"]
    shown = page_at.read_text("utf-8")
    assert "1 of 2 studies failed" in shown
    assert "1 more are to come" in shown
    stop.clear()
    assert report.main(command) == 1
    assert ran == ["layer", "verify", "verify", "sphere"]
    assert "layer kept" in capsys.readouterr().out
    shown = page_at.read_text("utf-8")
    assert "1 of 3 studies failed" in shown
    assert "to come" not in shown
    assert "answer: layer" in shown.replace("<p class=answer>", "answer: ")
    assert report.main(command) == 1
    assert ran[4:] == ["layer", "verify", "sphere"]  # all anew


def test_what_the_page_shows_is_small_and_the_rest_is_linked(tmp_path):
    folder = tmp_path / "big"
    folder.mkdir()
    figure, axes = canvas(12, 8)
    axes.pcolormesh(np.random.default_rng(1).random((50, 50)))
    figure.suptitle("Noise")
    (picture, *_) = save(figure, folder / "noise", pdf=False)
    table.write(folder / "all.csv", [], ["x"], [[i] for i in range(5000)])
    (folder / "printed.txt").write_text("word " * 5000)
    one = page.Section("big", "?", "word " * 5000, 0, folder, 1.0)
    shown = page.page([one], "a command", "facts")
    words = re.sub(r"<style>.*?</style>|<[^>]*>", " ", shown, flags=re.S).split()
    assert len(words) < 40
    assert len(shown) < 3000 + 0.8 * 4 / 3 * picture.stat().st_size
    for name in ("noise.png", "all.csv", "printed.txt"):
        assert f'href="big/{name}"' in shown
    failed = page.page([one._replace(status=1, printed="early\n" * 50 + "late\n")], "c", "f")
    assert "late" in failed
    assert failed.count("early") == page.LAST - 1


def test_figures_come_first_and_all_at_one_scale(tmp_path):
    folder = tmp_path / "one"
    folder.mkdir()
    for name, width in (("small", 5), ("wide", 10)):
        figure, _ = canvas(width, 4)
        save(figure, folder / name, pdf=False)
    said = "answer: All of them.\nmissed: a time\n"
    shown = page.page([page.Section("one", "What?", said, 0, folder, 1.0)], "a command", "facts")
    places = [shown.index(text) for text in ("<h2", "<figure", "All of them", "a time", "command")]
    assert places == sorted(places)
    assert shown.count("All of them") == 1
    widths = [int(width) for width in re.findall(r"--width:(\d+)px", shown)]
    assert widths == [round(report.SCALE * 140 * inches) for inches in (5, 10)]


def test_every_study_that_needs_no_input_is_in_the_report():
    tools = {"run", "new", "explore", "sweep", "fit", "plan", "report"}
    files = Path(report.__file__).parent.rglob("[!_]*.py")
    found = {str(file) for file in files if "\ndef main(" in file.read_text("utf-8")}
    listed = {name: importlib.import_module(module).__file__ for name, module in MODULES.items()}
    assert found == {*listed.values(), template.__file__}
    assert set(REPORTED) == set(STUDIES) - tools


def test_the_list_has_one_line_for_each_study():
    command = [sys.executable, "-W", "error", "-m", "studies"]
    ran = subprocess.run(command, capture_output=True, text=True, cwd=ROOT, check=False)
    assert (ran.returncode, ran.stderr) == (0, "")
    for name in command_line.STUDIES:
        (line,) = [line for line in ran.stdout.splitlines() if line.split()[:1] == [name]]
        assert line.endswith(importlib.import_module(MODULES[name]).__doc__.splitlines()[0])


def test_a_bad_scene_is_one_line_and_status_2(tmp_path, capsys):
    path = writer(tmp_path / "tiny.toml")(("h = 60e-6", 'h = "1 mm"'))
    assert command_line.main(["run", str(path), "--out", str(tmp_path)]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert len(err.splitlines()) == 1
    assert f"{path}: layer.h = '1 mm'" in err
    assert not (tmp_path / "tiny.csv").exists()


def test_the_list_costs_no_matplotlib():
    code = "import sys; from studies.__main__ import main; main([]); print(*sys.modules)"
    ran = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=ROOT)
    assert "studies" in ran.stdout.split()
    assert "matplotlib" not in ran.stdout.split()
