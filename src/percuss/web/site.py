"""The workbench as static files, for any web host or a folder on a stick.

A browser loads no module scripts and no other files from a folder of its own machine: so all
scripts, and the kernels, stand as texts in one classic script, which makes modules of them.
"""

from __future__ import annotations

import base64
import json
import shutil
from importlib import resources
from pathlib import Path

from percuss.errors import OutputError
from percuss.io.files import check_output_folder
from percuss.web.page_data import page_data
from percuss.web.wasm.sources import KERNELS_FILE
from percuss.web.widget import modules_in_order, text_of

# Where the page looks for the report.
REPORT = "report"
SITE_FILES = ("index.html", "percuss.css", "percuss.js", "icon.svg")

# What comes before the worker's modules are there is answered then.
_WORKER = """{import_texts}
const early = [];
onmessage = (event) => early.push(event);
importTexts({modules}).then(() => early.forEach((event) => onmessage(event)));
"""
_PAGE = """// The workbench of percuss {version}, as percuss site wrote it.
{import_texts}
const modules = {modules};
const site = {site};
importTexts(modules).then((page) => page.begin(document.getElementById("percuss"), site));
"""


def write_site(folder: Path, *, report: Path | None = None, force: bool = False) -> list[Path]:
    """Write the workbench as static files.

    Explore, the gallery, the figures of the paper, diagrams and basins work without a server: they
    are computed by the kernels in the browser. What needs Python says so.

    Parameters
    ----------
    folder
        Folder to write to; it is made.
    report
        Folder of a report of `percuss paper`, to be shown under "Paper"; or None.
    force
        Whether to write into a folder that is not empty.

    Returns
    -------
    list of Path
        The files; ``index.html``, the first one, is to be opened.

    Raises
    ------
    OutputError
        If the folder is not empty, cannot be written or lies in the report; if there is no such
        report.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     [file.name for file in write_site(Path(folder) / "site")]
    ['index.html', 'percuss.css', 'percuss.js', 'icon.svg']
    """
    if report is not None and not (report / "index.html").is_file():
        raise OutputError(report, "holds no report; write one with percuss paper --out")
    check_output_folder(folder, force=force)
    if report is not None and folder.resolve().is_relative_to(report.resolve()):
        raise OutputError(folder, f"lies in the report {report}; choose another folder")
    try:
        folder.mkdir(parents=True, exist_ok=True)
        files = []
        for name, text in _texts(report).items():
            (folder / name).write_text(text, encoding="utf-8")
            files.append(folder / name)
        if report is not None:
            if report.resolve() != (folder / REPORT).resolve():
                shutil.copytree(report, folder / REPORT, dirs_exist_ok=True)
            files += sorted(file for file in (folder / REPORT).rglob("*") if file.is_file())
    except OSError as error:
        raise OutputError(folder, (error.strerror or str(error)).lower()) from error
    return files


def _texts(report: Path | None) -> dict[str, str]:
    """Return the texts of all files, by their names."""
    import_texts = text_of("js/import_texts.js")
    facts = page_data(report) | {"certified": False}
    kernels = (resources.files("percuss.web") / "static" / KERNELS_FILE).read_bytes()
    site = {
        "facts": facts,
        "worker": _WORKER.format(
            import_texts=import_texts, modules=_literal(modules_in_order("js/worker.js"))
        ),
        "kernels": base64.b64encode(kernels).decode(),
    }
    page = _PAGE.format(
        version=facts["version"],
        import_texts=import_texts,
        modules=_literal(modules_in_order("js/site.js")),
        site=_literal(site),
    )
    style = text_of("vendor/uPlot.min.css") + text_of("style.css")
    texts = [text_of("site.html"), style, page, text_of("icon.svg")]
    return dict(zip(SITE_FILES, texts, strict=True))


def _literal(value: object) -> str:
    return json.dumps(value, ensure_ascii=True, separators=(",", ":"))
