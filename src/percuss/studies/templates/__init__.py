"""Study files to begin with: one commented file for each kind of oscillator and of study."""

from __future__ import annotations

from importlib import resources

from percuss.errors import ParameterError

# What a kind of study is called where its templates have other names.
_SAME = {"motion": "impact"}


def template_names() -> list[str]:
    """Return the names of the templates.

    Examples
    --------
    >>> template_names()[:6]
    ['backlash', 'ball', 'basins', 'bilinear', 'branch', 'curve']
    """
    files = resources.files(__name__).iterdir()
    return sorted(file.name.removesuffix(".toml") for file in files if file.name.endswith(".toml"))


def template_title(name: str) -> str:
    """Return what a template is about, in a line.

    Examples
    --------
    >>> template_title("ball")
    'a ball that bounces on a shaking table'
    """
    first, _, _ = template_text(name).partition("\n")
    return first.removeprefix("# A study for percuss: ").rstrip(".")


def template_text(name: str) -> str:
    """Return the text of a template.

    Parameters
    ----------
    name
        One of `template_names`, or a kind of study.

    Returns
    -------
    str
        A study file with a comment for each key.

    Raises
    ------
    ParameterError
        If there is no such template.
    """
    name = _SAME.get(name, name)
    if name not in template_names():
        known = ", ".join(template_names())
        raise ParameterError("template", name, f"not a template; the templates are {known}")
    return resources.files(__name__).joinpath(f"{name}.toml").read_text(encoding="utf-8")
