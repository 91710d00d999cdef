"""The report: one page that holds everything and says what failed."""

import importlib
import re
import shutil
from pathlib import Path

import pytest

from studies import MODULES, REPORTED, STUDIES, report, template


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    out = tmp_path_factory.mktemp("report")
    only = ["--only", "tolerance", "path_speed"]
    assert report.main(["--preset", "quick", *only, "--out", str(out)]) == 0
    return (out / "report.html").read_text("utf-8")


def test_the_page_needs_nothing_else(made):
    assert "data:image/png;base64," in made
    sources = re.findall(r"(?:src|href)=\"?([^\"> ]{0,20})", made)
    assert sources and all(source.startswith("data:image/") for source in sources)


def test_a_browser_shows_every_figure_and_complains_of_nothing(made, tmp_path):
    """Needs the extra `browser` and a Chromium, the system's or playwright's own."""
    sync_api = pytest.importorskip("playwright.sync_api", reason="the extra `browser` is absent")
    (tmp_path / "report.html").write_text(made, "utf-8")
    found = shutil.which("chromium") or shutil.which("google-chrome")
    with sync_api.sync_playwright() as playwright:
        try:
            browser = playwright.chromium.launch(executable_path=found, args=["--no-sandbox"])
        except sync_api.Error as error:
            pytest.skip(f"no browser starts: {str(error).splitlines()[0]}")
        page, said = browser.new_page(), []
        page.on("console", lambda message: said.append(message.text))
        page.on("pageerror", lambda error: said.append(str(error)))
        page.on("requestfailed", lambda request: said.append(request.url[:80]))
        page.goto((tmp_path / "report.html").as_uri())
        widths = page.evaluate("Array.from(document.images).map(image => image.naturalWidth)")
        fits = page.evaluate("document.documentElement.scrollWidth <= window.innerWidth")
        browser.close()
    assert len(widths) == made.count("<img") >= 2 and min(widths) > 500
    assert fits and not said


def test_the_page_says_where_it_comes_from_and_what_was_found(made):
    assert "numpy" in made and "python -m studies report --preset quick" in made
    assert "Is rtol honoured" in made and "honoured" in made
    assert "all studies passed" in made


def test_a_failing_study_is_shown_and_counts(tmp_path, monkeypatch, capsys):
    from studies.benchmarks import tolerance

    monkeypatch.setattr(tolerance, "passed", lambda trials: False)
    assert report.main(["--quick", "--only", "tolerance", "--out", str(tmp_path)]) == 1
    page = (tmp_path / "report.html").read_text("utf-8")
    assert "failed: tolerance" in page and "<h2 class=bad>tolerance" in page
    assert "FAILED" in capsys.readouterr().out

    def broken(params, jobs):
        raise ValueError("depth = nan <is> wrong")

    monkeypatch.setattr(tolerance, "run", broken)
    assert report.main(["--quick", "--only", "tolerance", "--out", str(tmp_path)]) == 1
    assert "depth = nan &lt;is&gt; wrong" in (tmp_path / "report.html").read_text("utf-8")


def test_the_verification_table_shows_a_failure(tmp_path):
    table = tmp_path / "verify.csv"
    table.write_text(
        "equation,what,error,order,fitted_error,passed\n"
        "16,line,1.234e-9,2.01,3e-15,True\n8,angle,1e-2,exact,nan,False\n",
        "utf-8",
    )
    shown = report.verification(table)
    assert "<td>1.2e-09</td>" in shown and "<td>exact</td>" in shown
    assert shown.count("class=bad") == 1 and "FAILED" in shown
    assert "not run" in report.verification(tmp_path / "none.csv")


def test_every_study_that_needs_no_input_is_in_the_report():
    tools = {"run", "new", "sweep", "fit", "report"}
    files = Path(report.__file__).parent.rglob("[!_]*.py")
    found = {str(file) for file in files if "\ndef main(" in file.read_text("utf-8")}
    listed = {name: importlib.import_module(module).__file__ for name, module in MODULES.items()}
    assert found == {*listed.values(), template.__file__}
    assert set(REPORTED) == set(STUDIES) - tools
