"""The report, one page that says what failed, and the command line of the studies."""

import importlib
import re
import subprocess
import sys
from pathlib import Path

import pytest
from scene_files import writer
from scenes import ROOT

from studies import MODULES, REPORTED, STUDIES, report, template
from studies import __main__ as command_line
from studies import report as page
from studies.benchmarks import speed
from studies.shared import figures

ROWS = [
    speed.Row("state, small slopes", 1e-4, 0.5, 0.1, 1.0, 1e-14, 1e-10),
    speed.Row("loop, depth", 0.1, 20.0, 0.1, 150.0, 1e-14, 1e-8),
]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    out = tmp_path_factory.mktemp("report")
    only = ["--only", "tolerance", "speed"]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(speed, "run", lambda p, show: ROWS)  # however busy the machine
        assert report.main(["--preset", "quick", *only, "--out", str(out)]) == 0
    return out


@pytest.fixture(scope="module")
def made(folder):
    return (folder / "report.html").read_text("utf-8")


@pytest.mark.slow
def test_every_figure_is_in_the_page_and_every_link_leads_to_a_file_beside_it(folder, made):
    sources = re.findall(r"src=\"?([^\"> ]{0,30})", made)
    assert len(sources) == 2 and all(s.startswith("data:image/png;base64,") for s in sources)
    links = re.findall(r"href=\"([^\"]+)\"", made)
    assert len(links) >= 6 and not any("//" in link or link.startswith("/") for link in links)
    for link in links:
        if link.startswith("#"):
            assert f"<h2 id={link[1:]}>" in made
        else:
            assert (folder / link).is_file()
    assert {"tolerance/tolerance.csv", "speed/speed.csv"} < set(links)


def test_a_study_answers_before_its_figures_which_have_captions(made):
    for name in ("tolerance", "speed"):
        own = made.split(f"<h2 id={name}>")[1].split("<h2")[0]
        question, answer, caption = (own.index(s) for s in ("?", "class=answer", "<figcaption>"))
        assert question < answer < caption
    assert "<figcaption>rtol is honoured and the estimate covers the error in 160 of 160" in made
    assert 'alt="rtol is honoured and' in made
    assert re.search(
        r'<a href="#tolerance">tolerance</a>: Is rtol .*? rtol is honoured in 60', made
    )


def test_tables_are_tables(made):
    own = made.split("<summary>speed.csv: 2 rows</summary>")[1].split("</table>")[0]
    assert own.count("<tr>") == 3 and "<th class=text>name</th>" in own and "<td>" in own
    assert "tolerance.csv: 480 rows, the first 100 of them</summary>" in made


def test_the_page_says_where_it_comes_from_and_what_was_found(made):
    assert "numpy" in made and "python -m studies report --preset quick" in made
    assert "Is rtol honoured" in made
    assert "<span class=good>All 2 studies passed.</span>" in made


@pytest.mark.slow
def test_a_failing_study_is_shown_and_counts(tmp_path, monkeypatch, capsys):
    from studies.benchmarks import tolerance

    monkeypatch.setattr(tolerance, "passed", lambda trials: False)
    assert report.main(["--quick", "--only", "tolerance", "--out", str(tmp_path)]) == 1
    made = (tmp_path / "report.html").read_text("utf-8")
    assert "<span class=bad>1 of 1 studies failed</span>: tolerance." in made
    assert made.count("<span class=bad>failed</span>") == 2  # in the contents and below
    assert "FAILED" in capsys.readouterr().out

    def broken(params, jobs):
        raise ValueError("depth = nan <is> wrong")

    monkeypatch.setattr(tolerance, "run", broken)
    assert report.main(["--quick", "--only", "tolerance", "--out", str(tmp_path)]) == 1
    assert "depth = nan &lt;is&gt; wrong" in (tmp_path / "report.html").read_text("utf-8")


def test_the_verdict_agrees_with_the_studies():
    def one(name, printed="", status=0):
        return page.Section(name, "?", printed, status, Path(), 1.0)

    assert "All 1 studies passed." in page.verdict([one("a")])
    slow, wrong = one("slow", "text\nmissed: time\n"), one("wrong", "missed: time\n", 1)
    assert "2 studies passed, but not all" in page.verdict([one("a"), slow])
    told = page.verdict([one("a"), slow, wrong])
    assert "1 of 3 studies failed</span>: wrong. Limits missed: slow." in told
    assert [x.verdict for x in (slow, wrong)] == ["passed, but missed 1 of its limits", "failed"]


def test_the_verification_table_shows_a_failure(tmp_path):
    (tmp_path / "verify").mkdir()
    (tmp_path / "verify" / "verify.csv").write_text(
        "# command: x\nequation,what,error,order,fitted_error,passed\n"
        "16,line,1.234567e-9,2.01,3e-15,True\n8,<angle>,1e-2,exact,nan,False\n",
        "utf-8",
    )
    verify = page.Section("verify", "?", "", 1, tmp_path / "verify", 1.0)
    shown = page.page([verify], "a command", "facts")
    assert "<td class=text>&lt;angle&gt;</td>" in shown and "<td>—</td>" in shown
    assert "<td class=text>exact</td>" in shown and "<td>1.235e-09</td>" in shown
    assert shown.count("<tr class=bad>") == 1 and "<details open>" in shown


@pytest.mark.parametrize("title", ["Error of a", "Größe γ₁ < 1"])
def test_a_figure_carries_its_title(tmp_path, title):
    figure = figures.canvas(3, 3)[0]
    figure.suptitle(title)
    png, _ = figures.save(figure, tmp_path / "a.png")
    assert page.caption(png.read_bytes()) == title
    assert page.caption(b"GIF89a") == ""


def test_every_study_that_needs_no_input_is_in_the_report():
    tools = {"run", "new", "sweep", "fit", "report"}
    files = Path(report.__file__).parent.rglob("[!_]*.py")
    found = {str(file) for file in files if "\ndef main(" in file.read_text("utf-8")}
    listed = {name: importlib.import_module(module).__file__ for name, module in MODULES.items()}
    assert found == {*listed.values(), template.__file__}
    assert set(REPORTED) == set(STUDIES) - tools


@pytest.fixture
def written(tmp_path):
    return writer(tmp_path / "tiny.toml")


def studies(*arguments):
    command = [sys.executable, "-W", "error", "-m", "studies", *arguments]
    return subprocess.run(command, capture_output=True, text=True, cwd=ROOT, check=False)


def test_the_list_has_one_line_for_each_study():
    ran = studies()
    assert ran.returncode == 0
    assert ran.stderr == ""
    assert set(command_line.STUDIES) >= {"run", "verify", "speed"}
    for name in command_line.STUDIES:
        (line,) = [line for line in ran.stdout.splitlines() if line.split()[:1] == [name]]
        doc = importlib.import_module(MODULES[name]).__doc__
        assert line.endswith(doc.splitlines()[0])


def test_an_unknown_study_is_answered_with_the_known_ones():
    ran = studies("dance")
    assert (ran.returncode, ran.stdout) == (2, "")
    assert "'dance'" in ran.stderr
    assert all(name in ran.stderr for name in command_line.STUDIES)
    assert len(ran.stderr.splitlines()) == 1


def test_a_bad_scene_is_one_line_and_status_2(written, tmp_path):
    path = written(("h = 60e-6", 'h = "1 mm"'))
    ran = studies("run", str(path), "--out", str(tmp_path))
    assert (ran.returncode, ran.stdout) == (2, "")
    assert len(ran.stderr.splitlines()) == 1
    assert f"{path}: layer.h = '1 mm'" in ran.stderr
    assert not (tmp_path / "tiny.csv").exists()


def test_the_list_costs_no_matplotlib():
    code = "import sys; from studies.__main__ import main; main([]); print(*sys.modules)"
    ran = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, cwd=ROOT, check=True
    )
    assert "studies" in ran.stdout.split()
    assert "matplotlib" not in ran.stdout.split()
