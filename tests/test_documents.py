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
SOURCES = ROOT / "src" / "percuss"
BUILT = ("_build", "gallery")
PAGES = {
    page.relative_to(DOCS).as_posix(): page
    for page in sorted(DOCS.rglob("*.md"))
    if page.relative_to(DOCS).parts[0] not in BUILT
}

# Whole pages that cannot run in seconds or not here, and why.
NOT_RUN = {
    "certified-howto.md": "tests/certified/test_howto.py runs it, and looks at what it shows",
    "cluster.md": "needs a queue or a cloud",
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

    page_code.run(PAGES[name])

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
        if not target.is_file() or (
            anchor and anchor not in slugs_of(target.read_text(encoding="utf-8"))
        ):
            broken.append(link)

    assert broken == []


def exists_in_code(reference: str) -> bool:
    """Return whether `module.name`, with or without the folders before it, is defined."""
    *folders, module, name = reference.split(".")
    files = [*SOURCES.rglob(f"{'/'.join([*folders, module])}.py")]
    files += SOURCES.rglob(f"{'/'.join([*folders, module, name])}.py")
    files += SOURCES.rglob(f"{'/'.join([*folders, module, name])}/__init__.py")
    return any(
        file.stem in (name, "__init__")
        or re.search(rf"^\s*(def |class )?{name}\b", file.read_text(encoding="utf-8"), re.MULTILINE)
        for file in files
    )


@pytest.mark.parametrize(
    "name", [name for name in PAGES if name.startswith("theory/") and name != "theory/certified.md"]
)
def test_the_code_that_a_theory_page_names_is_there(name: str) -> None:
    references = re.findall(r"`((?:[a-z_]+\.)+(?!py`|md`)[A-Za-z_]+)`", text_of(name))

    missing = [
        reference
        for reference in references
        if not reference.startswith(("percuss.", "run.")) and not exists_in_code(reference)
    ]

    assert missing == []


# Folders that commands make.
MADE = {"demo/", "dist/"}


def missing_paths(text: str) -> list[str]:
    """Return the files and folders in backticks that are neither in the package nor beside it."""
    missing = []
    for line in text.splitlines():
        folders = {SOURCES, ROOT}
        for path in re.findall(r"`([\w.*-]*(?:/[\w.*-]*)+|\w+\.py)`", line):
            files = [file for folder in folders for file in folder.glob(path.rstrip("/"))]
            # Names without a folder lie in that of one before, as in `a/b.py`, `c.py`.
            folders |= {file.parent for file in files}
            if not files and path not in MADE:
                missing.append(path)
    return missing


@pytest.mark.parametrize("page", ["docs/architecture.md", "CONTRIBUTING.md"])
def test_the_files_that_a_page_on_the_house_names_are_there(page: str) -> None:
    assert missing_paths((ROOT / page).read_text(encoding="utf-8")) == []


def test_a_file_that_is_not_there_is_seen() -> None:
    text = "`model/paths.py`, `forcing.py`, `march.py`, `demo/` and `orbits/nothing/`"

    assert missing_paths(text) == ["march.py", "orbits/nothing/"]


def test_every_page_stands_in_a_table_of_contents() -> None:
    listed = {"index.md"}
    for name, page in PAGES.items():
        for block in re.findall(r"```\{toctree\}\n(.*?)```", text_of(name), flags=re.DOTALL):
            for line in block.splitlines():
                entry = re.sub(r".*<(.+)>$", r"\1", line.strip())
                if entry and not entry.startswith(":"):
                    entries = page.parent.glob(f"{entry}.md") if "*" in entry else [
                        (page.parent / f"{entry}.md").resolve()]  # fmt: skip
                    listed |= {path.relative_to(DOCS).as_posix() for path in entries}

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

    runpy.run_path(str(script))
    assert plt.get_fignums()
    for number in plt.get_fignums():
        plt.figure(number).savefig(tmp_path / f"{number}.png")


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


def measured(section: str, quantity: str) -> float | None:
    """Give a number of docs/benchmarks.md, None where the table is older than the line."""
    part = re.search(
        rf"^## {re.escape(section)}.*?\n(.*?)(?=^## |\Z)",
        text_of("benchmarks.md"),
        re.DOTALL | re.MULTILINE,
    )
    line = part and re.search(rf"^\| {re.escape(quantity)} \| ([0-9.,e+-]+)", part[1], re.MULTILINE)
    return float(line[1].replace(",", "")) if line else None


PER_IMPACT = {
    "W1": "percuss, ns per impact of 100,000 (aim)",
    "W2": "percuss, ns per impact",
    "W4": "percuss, ns per impact",
}


@pytest.mark.parametrize("page", [ROOT / "README.md", DOCS / "index.md"])
def test_the_speed_that_a_page_opens_with_is_the_measured_one(page: Path) -> None:
    text = " ".join(page.read_text(encoding="utf-8").split())

    assert re.search(r"under half a microsecond an impact for one harmonic and a wall \(\[", text)
    assert not re.search(r"[0-9] ?(us|µs|microseconds) an impact", text)
    for section, quantity in PER_IMPACT.items():
        found = measured(section, quantity)
        assert found is not None, section
        assert found < 500.0, section


@pytest.mark.parametrize(
    ("row", "measure"),
    [
        ("an impact, `period`", "period"),
        ("an impact, `largest_lyapunov_exponent`", "largest_lyapunov_exponent"),
        ("an impact, both", "period and largest_lyapunov_exponent"),
        ("an impact, `peak_displacement`", "peak_displacement"),
    ],
)
def test_the_rates_that_a_cluster_is_reckoned_with_are_the_measured_ones(
    row: str, measure: str
) -> None:
    found = measured("Measures of a sweep", f"{measure}, ns per impact")
    if found is None:
        pytest.skip("docs/benchmarks.md is older than the benchmark of measures")
    said = re.search(rf"^\| {re.escape(row)} \| ([0-9.]+) us", text_of("cluster.md"), re.MULTILINE)

    assert said is not None
    # What is reckoned with them is rounder.
    assert float(said[1]) * 1e3 == pytest.approx(found, rel=0.3)


def test_the_rows_of_the_comparison_are_those_of_the_benchmarks() -> None:
    """Each number of the table stands in the benchmarks, rounded; w1 to w4 by their sections."""
    text = text_of("comparison.md")
    w1, w2, w3, w4 = "W1", "W2", "W3", "W4"
    rows: list[tuple[str, list[tuple[str, str, float]]]] = [
        ("an elastic impact under sin 3t, 100,000 of them (W1)", [
            (w1, PER_IMPACT["W1"], 1.0),
            (w1, "heyoka with its callback, ns per impact", 1.0),
        ]),
        ("an impact in a sweep over the frequency (W2)", [
            (w2, PER_IMPACT["W2"], 1.0), (w2, "heyoka, ns per impact", 1.0),
        ]),
        ("200 periods of a basin's motion (W4)", [
            # Of 200 x 200 starts, in ms.
            (w4, "percuss, whole basin", 1e3 / 40_000),
            (w4, "heyoka, a motion of 200 periods", 1.0), (w4, "SciPy, a motion of 200 periods", 1.0),
        ]),
        ("a stiff bilinear oscillator, motion and 2^20 samples (W3)", [
            (w3, f"{name}, motion and sampling", 1.0) for name in ("percuss", "heyoka", "SciPy")
        ]),
        ("a single near-grazing event", [
            ("Near-grazing first events", f"{name}, us per case", 1.0)
            for name in ("percuss", "heyoka", "SciPy")
        ]),
        *((f"an event of {motion}", [
            ("Structures", f"{name}, {short}, us an event", 1.0) for name in ("percuss", "heyoka")
        ]) for motion, short in (
            ("two masses with a soft stop and a wall", "two masses"),
            ("a beam of 10 modes at a stop", "a beam of 10 modes"),
        )),
    ]  # fmt: skip
    for name, cells in rows:
        line = next(line for line in text.splitlines() if line.startswith(f"| {name} |"))
        said = [
            float(it.replace(",", "")) for it in re.findall(r"[\d.,]*\d(?= (?:ns|ms|us))", line)
        ]
        assert len(said) >= len(cells), name
        for (section, quantity, factor), number in zip(cells, said, strict=False):
            found = measured(section, quantity)
            assert found is not None, (section, quantity)
            assert number == pytest.approx(found * factor, rel=0.02), (name, quantity)
