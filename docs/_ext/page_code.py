"""The code of the pages: run in order, in one namespace, in an empty folder.

python docs/_ext/page_code.py makes the pictures of docs/howto anew: each page draws its own.
"""

from __future__ import annotations

import contextlib
import doctest
import io
import re
import shutil
import tempfile
from pathlib import Path
from typing import Any

DOCS = Path(__file__).parents[1]

# A block after this comment, with its reason, is not run.
MARKER = "<!-- not run: "
BLOCK = re.compile(r"(<!-- not run: [^>]+-->\s*)?^```python\n(.*?)^```", re.DOTALL | re.MULTILINE)


def blocks(text: str) -> list[str]:
    """Return the Python blocks of a page that are to be run; each begins at its own line."""
    found = []
    for match in BLOCK.finditer(text):
        if match[1] is None:
            found.append("\n" * text.count("\n", 0, match.start(2)) + match[2])
    return found


def run(page: Path) -> int:
    """Run the blocks of a page in the current folder, and return how many they were."""
    namespace: dict[str, Any] = {"__name__": "page"}
    code = blocks(page.read_text(encoding="utf-8"))
    for block in code:
        if ">>> " in block:
            _run_examples(block, page, namespace)
        else:
            exec(compile(block, str(page), "exec"), namespace)  # noqa: S102  our own text
    return len(code)


def _run_examples(block: str, page: Path, namespace: dict[str, Any]) -> None:
    test = doctest.DocTestParser().get_doctest(block, namespace, page.name, str(page), 0)
    said: list[str] = []
    result = doctest.DocTestRunner(verbose=False).run(test, out=said.append, clear_globs=False)
    namespace.update(test.globs)
    if result.failed:
        raise AssertionError("".join(said))


def main() -> None:
    """Make the pictures of the pages by task anew."""
    import matplotlib as mpl

    mpl.use("agg")
    for page in sorted((DOCS / "howto").glob("*.md")):
        with tempfile.TemporaryDirectory() as folder:
            with contextlib.chdir(folder), contextlib.redirect_stdout(io.StringIO()):
                run(page)
            for picture in sorted(Path(folder).glob("*.png")):
                shutil.copy(picture, DOCS / "howto" / "images" / picture.name)
                print(picture.name)  # noqa: T201


if __name__ == "__main__":
    main()
