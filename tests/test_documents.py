"""The documents: their code runs, their links lead somewhere, every public name has its entry."""

from __future__ import annotations

import importlib
import importlib.util
import re
import runpy
from pathlib import Path
from types import ModuleType

import matplotlib as mpl
import pytest

ROOT = Path(__file__).parents[1]
DOCS = ROOT / "docs"
BUILT = ("_build", "gallery")
PAGES = {
    page.relative_to(DOCS).as_posix(): page
    for page in sorted(DOCS.rglob("*.md"))
    if page.relative_to(DOCS).parts[0] not in BUILT
}

# Whole pages that cannot run in seconds or not here, and why.
NOT_RUN = {
    "cluster.md": "needs a queue or a cloud",
    "ensembles.md": "shows parts of calls; its pictures are made by examples/",
    "response-charts.md": "a minute of search; examples/bilinear_response.py does it",
}

FORMULA = r"\$\$(.+?)\$\$|(?<![\\$])\$([^$\n]+)\$"


def extension(name: str) -> ModuleType:
    """Give a module of docs/_ext, which is no package."""
    spec = importlib.util.spec_from_file_location(name, DOCS / "_ext" / f"{name}.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


page_code = extension("page_code")


def text_of(name: str) -> str:
    return PAGES[name].read_text(encoding="utf-8")


def without_code(text: str) -> str:
    return re.sub(r"^```.*?^```|`[^`\n]+`", "", text, flags=re.DOTALL | re.MULTILINE)


def without_formulas(text: str) -> str:
    return re.sub(FORMULA, "", text, flags=re.DOTALL)


WITH_CODE = [name for name in PAGES if page_code.blocks(text_of(name))]


@pytest.mark.parametrize("name", [name for name in WITH_CODE if name not in NOT_RUN])
def test_the_code_of_a_page_runs(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    mpl.use("agg")
    from matplotlib import pyplot as plt

    try:
        page_code.run(PAGES[name])
    finally:
        plt.close("all")

    drawn = {picture.name for picture in tmp_path.glob("*.png")}
    shown = {Path(link).name for link in re.findall(r"!\[[^]]*\]\(([^)]+)\)", text_of(name))}
    assert drawn <= shown


def test_blocks_that_do_not_run_are_few_and_say_why() -> None:
    assert set(WITH_CODE) >= set(NOT_RUN)
    assert sum(text_of(name).count(page_code.MARKER) for name in PAGES) <= 3


def test_an_error_in_a_page_is_seen(tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    page.write_text("```python\na = 1\n```\n\n```python\nassert a == 2\n```\n", encoding="utf-8")
    with pytest.raises(AssertionError):
        page_code.run(page)

    page.write_text("```python\n>>> 1 + 1\n3\n\n```\n", encoding="utf-8")
    with pytest.raises(AssertionError, match="Expected"):
        page_code.run(page)


def slugs_of(text: str) -> set[str]:
    """Give the anchors of a page's headings, as code hosts and MyST make them."""
    headings = re.findall(r"^#+ (.+)$", re.sub(r"(?ms)^```.*?^```", "", text), flags=re.MULTILINE)
    plain = [re.sub(r"\[([^]]*)\]\([^)]*\)", r"\1", it).strip().lower() for it in headings]
    return {re.sub(r"[^\w\- ]", "", it).replace(" ", "-") for it in plain}


def target_of(page: Path, link: str) -> Path:
    """Give the file that a link leads to; of built pages the script that they are made from."""
    target = (page.parent / link).resolve()
    if target.is_relative_to(DOCS / "gallery"):
        source = target.relative_to(DOCS / "gallery").with_suffix(".py")
        return (
            ROOT / "examples" / "gallery" / ("README.rst" if link.endswith("index.rst") else source)
        )
    return target


@pytest.mark.parametrize("name", list(PAGES))
def test_the_links_of_a_page_lead_somewhere(name: str) -> None:
    page, broken = PAGES[name], []
    for link in re.findall(r"\]\(([^)\s]+)\)", without_formulas(without_code(text_of(name)))):
        path, _, anchor = link.partition("#")
        if re.match(r"https?:|mailto:", link):
            continue
        target = target_of(page, path) if path else page
        there = target.is_file()
        if not there or (anchor and anchor not in slugs_of(target.read_text(encoding="utf-8"))):
            broken.append(link)

    assert broken == []


def test_every_page_stands_in_a_table_of_contents() -> None:
    listed = {"index.md"}
    for name, page in PAGES.items():
        for block in re.findall(r"```\{toctree\}\n(.*?)```", text_of(name), flags=re.DOTALL):
            for line in block.splitlines():
                entry = re.sub(r".*<(.+)>$", r"\1", line.strip())
                if entry and not entry.startswith(":"):
                    found = page.parent.glob(f"{entry}.md") if "*" in entry else [
                        (page.parent / f"{entry}.md").resolve()]  # fmt: skip
                    listed |= {it.relative_to(DOCS).as_posix() for it in found}

    assert set(PAGES) - listed == set()


@pytest.mark.parametrize("module", ["percuss", "percuss.plotting", "percuss.certified"])
def test_every_public_name_has_an_entry_in_the_reference(module: str) -> None:
    if module == "percuss.certified":
        pytest.importorskip("flint")
    entries = set()
    for page in (DOCS / "api").glob("*.md"):
        here = ""
        for line in page.read_text(encoding="utf-8").splitlines():
            directive, _, what = line.partition(":: ")
            if directive == ".. currentmodule":
                here = what
            elif directive in (".. autofunction", ".. autoclass"):
                entries.add(f"{here}.{what}")

    public = set(importlib.import_module(module).__all__) - {"__version__"}
    assert public
    homes = (module, "percuss")
    assert {it for it in public if not {f"{home}.{it}" for home in homes} & entries} == set()


SCRIPTS = sorted((ROOT / "examples" / "gallery").glob("plot_*.py"))


@pytest.mark.nightly
@pytest.mark.parametrize("script", SCRIPTS, ids=[script.stem for script in SCRIPTS])
def test_a_script_of_the_gallery_runs_and_draws(
    script: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    mpl.use("agg")
    from matplotlib import pyplot as plt

    try:
        runpy.run_path(str(script))
        assert plt.get_fignums()
        for number in plt.get_fignums():
            plt.figure(number).savefig(tmp_path / f"{number}.png")
    finally:
        plt.close("all")


def formulas() -> list[str]:
    """Give every formula of every page."""
    found = []
    for name in PAGES:
        for block, inline in re.findall(FORMULA, without_code(text_of(name)), flags=re.DOTALL):
            found.append(block or inline)
    return found


def test_every_formula_becomes_mathml() -> None:
    pytest.importorskip("latex2mathml", reason="stands in the group docs")
    mathml = extension("formulas").mathml

    assert len(formulas()) > 500
    for formula in formulas():
        assert mathml(formula, "inline").startswith("<math")
    with pytest.raises(ValueError, match="unheard"):
        mathml(r"\unheard x", "inline")


def test_pictures_of_the_how_to_pages_are_all_shown() -> None:
    shown = set(re.findall(r"\(images/([^)]+)\)", "".join(map(text_of, PAGES))))
    there = {picture.name for picture in (DOCS / "howto" / "images").glob("*.png")}

    assert there
    assert there <= shown
