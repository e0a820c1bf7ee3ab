"""Study files with one to three things changed at random: keys, values, types, and their text."""

from __future__ import annotations

import copy
import math
import random
import string
import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

from percuss.io.study_text import toml_string
from percuss.studies.templates import template_names, template_text

Path = tuple[str | int, ...]

# What the templates leave out, so that every key of every kind of study is changed at times.
_MORE: dict[str, dict[str, Any]] = {
    "impact": {"certify": {"digits": 12}, "run": {"max_impacts": 50}, "forcing": {"period": "2*pi/3"}},
    "bilinear": {
        "oscillator": {"damping": None, "mass": 2, "damping_ratio": "0.02"},
        "draw": {"window": [1, "2*pi"]},
        "save": {"samples": 50},
    },
    "ball": {"forcing": {"harmonics": None, "omega": 1, "cos": [1, "0.5"], "sin": [0, "1/3"]}},
    "orbit": {"certify": {"digits": 12}, "orbit": {"cycle": "0.01", "v_after": "-1.3"}},
    "branch": {"orbit": {"sequence": [0]}, "certify": {"digits": 5}},
    "sweep": {"over": {"oscillator.damping": ["0.05", "0.1"]}},
    "basins": {"basins": {"stop": 0}},
}  # fmt: skip
# What makes the work small: mutants differ in shape, not in size.
_SMALL: dict[str, Any] = {
    "periods": 64, "max_impacts": 50, "t_end": 20, "count": 3, "points": 4, "transient": 4,
    "max_points": 12, "samples": 20, "n_seeds": 1, "max_periods": 1, "rounds": 4,
    "largest_step": 0.2, "max_impacts_in_round": 2, "svg": False,
}  # fmt: skip

_NUMBERS: tuple[Any, ...] = (
    0, -0.0, 1, -1, 2, 0.5, 1e-300, 5e-324, -1e-16, 1e-9, 1e9, 1e17, -1e17, 1e300, 1.7e308,
    2**63, -(2**63), 10**30, math.nan, math.inf, -math.inf, "1/3", "-2/7", "1e-9", "1e400",
    "1/0", "pi", "pi/2", "-pi/3 + 1/7", "1e999999", "9" * 400, " 2 ", "0x10", "1_000", "٣",
)  # fmt: skip
_FACTORS = (0, -1, 0.5, 0.9, 1 + 2**-52, 1.1, 2, 3, 10, 1e3, 1e8, 1e-3, 1e-8)
_OTHERS: tuple[Any, ...] = (
    "", "abc", "nan", "\u202e\x07", "ω = Übung \u22121 \U0001f600", "a" * 5000, True, False, [], [[]], [0], [0, 1, 2], [1, "x"],
    ["a", "b"], {}, {"from": 0, "to": 1, "count": 2}, {"a": {"b": 1}}, [{"at": 0}], "above", "below", "soft",
    "wall", "log", "fold", "forcing.omega", "oscillator.stops.7.at", "start.x0", "period",
)  # fmt: skip


# Tables whose keys are names that the user has chosen.
_OWN_NAMES = {("parameters",), ("structure", "points")}


@dataclass(frozen=True)
class Mutant:
    """A text, and what was done to the template that it came from."""

    text: str
    changes: tuple[str, ...]
    # Keys that are certainly wrong: each has to be named.
    wrong: tuple[Path, ...]


@cache
def _templates() -> tuple[dict[str, Any], ...]:
    """Return the templates as tables, with what they leave out, both small."""
    found = []
    for name in template_names():
        document = tomllib.loads(template_text(name))
        found.append(_joined(document, _MORE.get(name, {})))
        found.append(document)
    return tuple(found)


def _joined(document: dict[str, Any], more: Mapping[str, Any]) -> dict[str, Any]:
    found = copy.deepcopy(document)
    for table, keys in more.items():
        joined = {**found.get(table, {}), **keys}
        found[table] = {key: value for key, value in joined.items() if value is not None}
    return found


def small(value: Any, key: str = "") -> Any:
    """Return a document with less to do: counts and numbers of points no larger than a few."""
    if isinstance(value, dict):
        return {name: small(inner, name) for name, inner in value.items()}
    if isinstance(value, list):
        return [small(inner) for inner in value]
    least = _SMALL.get(key)
    is_number = isinstance(value, int | float) and not isinstance(value, bool)
    if least is not None and is_number and math.isfinite(value):
        return min(value, least)
    return value


def text_of(name: str) -> str:
    """Return a template with little to do."""
    return _toml(small(tomllib.loads(template_text(name))))


def mutant(seed: int) -> Mutant:
    """Return the mutant of this number."""
    dice = random.Random(seed)
    document = copy.deepcopy(dice.choice(_templates()))
    changes, wrong = [], []
    for _ in range(dice.choice((1, 1, 1, 2, 3))):
        change, path, is_wrong = _changed(document, dice)
        changes.append(f"{change} {'.'.join(map(str, path))}")
        wrong += [path] if is_wrong else []
    # Of several changes a later one may undo, or hide, what an earlier one did.
    wrong = wrong if len(changes) == 1 else []
    text = _toml(small(document))
    if dice.random() < 0.15:
        text, change = _torn(text, dice)
        changes.append(change)
        wrong = []
    return Mutant(text, tuple(changes), tuple(wrong))


def _changed(document: dict[str, Any], dice: random.Random) -> tuple[str, Path, bool]:
    """Change one thing in place; return what, where, and whether it is certainly wrong."""
    places = list(_places(document))
    path = dice.choice(places)
    owner = _owner(document, path)
    key = path[-1]
    before = owner[key]
    is_number = isinstance(before, int | float) and not isinstance(before, bool)
    what = dice.choice(
        ("scale",) * 6 * is_number + ("number", "number", "other", "remove", "rename", "copy")
    )
    if isinstance(owner, list):
        what = {"rename": "other"}.get(what, what)
    if what == "remove":
        del owner[key]
        return what, path, False
    if what == "rename":
        name = _misspelt(str(key), dice)
        owner[name] = owner.pop(key)
        is_wrong = name != key and path[:-1] not in _OWN_NAMES
        return f"rename to {name!r}", (*path[:-1], name), is_wrong
    if what == "copy":
        source = dice.choice(places)
        owner[key] = copy.deepcopy(_owner(document, source)[source[-1]])
        return f"copy {'.'.join(map(str, source))} to", path, False
    if what == "scale":
        owner[key] = type(before)(before * dice.choice(_FACTORS))
        return f"{owner[key]!r} as", path, False
    value = dice.choice(_NUMBERS if what == "number" else _OTHERS)
    owner[key] = copy.deepcopy(value)
    is_bad = isinstance(value, bool | dict) or (
        isinstance(value, float) and not math.isfinite(value)
    )
    return f"{value!r:.40} as", path, is_number and is_bad and path != ("orbit", "impacts")


def _places(value: Any, path: Path = ()) -> Iterator[Path]:
    items = value.items() if isinstance(value, dict) else enumerate(value)
    for key, inner in items:
        yield (*path, key)
        if isinstance(inner, dict | list):
            yield from _places(inner, (*path, key))


def _owner(document: Any, path: Path) -> Any:
    for part in path[:-1]:
        document = document[part]
    return document


def _misspelt(key: str, dice: random.Random) -> str:
    place = dice.randrange(max(1, len(key)))
    return dice.choice((
        key[:place] + dice.choice(string.ascii_lowercase + "._ \"'\n\0ωé") + key[place:],
        key[:place] + key[place + 1 :] + "_" * (len(key) < 2),
        key.upper() if key.upper() != key else f"{key}_",
        "",
    ))  # fmt: skip


def _torn(text: str, dice: random.Random) -> tuple[str, str]:
    """Return a text with a piece cut out, doubled or replaced, as an editor leaves it."""
    lines = text.split("\n")
    number, place = dice.randrange(len(lines)), dice.randrange(len(text))
    what = dice.choice(("cut", "double", "line", "noise", "windows", "mark"))
    if what == "cut":
        return text[:place], f"cut at {place}"
    if what == "double":
        return "\n".join(lines[: number + 1] + lines[number:]), f"double line {number}"
    if what == "line":
        return "\n".join(lines[:number] + lines[number + 1 :]), f"drop line {number}"
    if what == "windows":
        return text.replace("\n", "\r\n"), "line ends of Windows"
    noise = "\ufeff" if what == "mark" else "".join(dice.choices('[]{}=,."#\\\n\t\0é\u2028', k=3))
    return text[:place] + noise + text[place:], f"{noise!r} at {place}"


def _toml(document: dict[str, Any]) -> str:
    """Return TOML text; unlike the one of percuss it takes all values."""
    blocks: list[str] = []
    for name, table in document.items():
        if not isinstance(table, dict):
            blocks.insert(0, f"{toml_string(name)} = {_value(table)}")
            continue
        rows = {k: v for k, v in table.items() if _is_rows(v)}
        keys = [f"{toml_string(k)} = {_value(v)}" for k, v in table.items() if k not in rows]
        blocks.append("\n".join([f"[{toml_string(name)}]", *keys]))
        for key, entries in rows.items():
            head = f"[[{toml_string(name)}.{toml_string(key)}]]"
            blocks += [
                "\n".join([head, *(f"{toml_string(k)} = {_value(v)}" for k, v in entry.items())])
                for entry in entries
            ]
    return "\n".join(blocks) + "\n"


def _is_rows(value: Any) -> bool:
    return isinstance(value, list) and bool(value) and all(isinstance(it, dict) for it in value)


def _value(value: Any) -> str:
    if isinstance(value, dict):
        return "{" + ", ".join(f"{toml_string(k)} = {_value(v)}" for k, v in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(_value, value)) + "]"
    if isinstance(value, bool):
        return "true" if value else "false"
    return toml_string(value) if isinstance(value, str) else repr(value)
