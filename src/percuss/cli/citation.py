"""The citation of percuss, from the metadata of the installed package, as CITATION.cff says it."""

from __future__ import annotations

from importlib import metadata

from percuss.version import __version__

TITLE = "percuss: exact motion of oscillators that hit stops, soft or rigid"


def citation() -> str:
    """Return the reference in a line, and what else to cite."""
    return (
        f"{_authors()}, {TITLE}, version {__version__} (software, {_licence()} licence)\n"
        "Cite the papers whose methods you use as well; the documents name them in docs/theory/."
    )


def bibtex_entry() -> str:
    """Return the reference as an entry of BibTeX."""
    # Braces keep an institution from being read as a name and a surname.
    rows = {
        "author": f"{{{_authors()}}}",
        "title": f"{{{TITLE}}}",
        "version": __version__,
        "note": f"Software, {_licence()} licence",
    }
    inner = "\n".join(f"  {name} = {{{text}}}," for name, text in rows.items())
    return f"@software{{percuss,\n{inner}\n}}"


def _authors() -> str:
    about = metadata.metadata("percuss")
    return about["Author"] or about["Author-email"] or "percuss developers"


def _licence() -> str:
    about = metadata.metadata("percuss")
    return about["License-Expression"] or "MIT"
