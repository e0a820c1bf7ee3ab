"""Measurements and records in files of separated values, as data loggers and spreadsheets write them."""

from __future__ import annotations

import csv
import difflib
import math
import re
from collections.abc import Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from typing import TypeAlias

import numpy as np

from percuss.arrays import Floats
from percuss.fitting.columns import (
    NO_UNIT,
    POWERS,
    FileColumn,
    converted,
    factor_of,
    force_factor,
    kind_of,
    known_names,
    name_and_unit,
    quantity_named,
    unit_of,
)
from percuss.model.units import Units
from percuss.wording import closest, counted

MISSING = ("", "nan", "na", "n/a", "#n/a", "null", "none", "-", "--")
NOTES = ("#", "%")
SEPARATORS = (";", "\t", ",", None)
NAMED = {";": "semicolons", "\t": "tabs", ",": "commas", None: "blanks"}
# Lines above the names, at most: the notes of a data logger.
MOST_LINES_ABOVE = 60
MOST_TOLD = 10
# Marks of thousands, which may as well be decimals.
_OF_THOUSANDS = re.compile(r"[-+]?[1-9]\d{0,2}((\.\d{3})+(,\d*)?|(,\d{3})+\.\d*)")
OTHER_SEPARATOR = "; with decimal commas separate the columns with semicolons"
_DECIMAL_COMMA = re.compile(r"[-+]?\d*,\d+(e[-+]?\d+)?", re.IGNORECASE)

NumberedRow: TypeAlias = "tuple[int, list[str]]"


def columns_of_file(
    path: Path, units: Units | None = None, columns: Mapping[str, str] | None = None
) -> dict[str, Floats]:
    """Return the columns of a file; as `columns_of_text`.

    Raises
    ------
    OSError
        If it cannot be read.
    ValueError
        With all its faults.
    """
    return columns_of_text(text_of_file(path), units, columns)


def text_of_file(path: Path) -> str:
    """Return the text of a table, as spreadsheets of any age encode it.

    Raises
    ------
    OSError
        If it cannot be read.
    ValueError
        If it is no text.
    """
    raw = path.read_bytes()
    is_wide = raw.startswith((b"\xff\xfe", b"\xfe\xff"))
    if b"\0" in raw[:1000] and not is_wide:
        raise ValueError("no text, but a binary file; save it as CSV")
    try:
        return raw.decode("utf-16" if is_wide else "utf-8-sig")
    except UnicodeDecodeError:
        # Of older spreadsheets.
        return raw.decode("cp1252", errors="replace")


def columns_of_text(
    text: str, units: Units | None = None, columns: Mapping[str, str] | None = None
) -> dict[str, Floats]:
    r"""Return the columns of a table of separated values by the names of quantities.

    Parameters
    ----------
    text
        Names, below them numbers, between commas, semicolons, tabs or blanks; decimal commas where
        commas do not separate. Lines that begin with # or % are notes, and so is what stands above
        the names. A name may have its unit in brackets, or a line of units may follow. Empty cells
        and NaN are missing values.
    units
        Those of the model, into which columns with a unit are converted.
    columns
        The names of columns by quantity, "" to leave one out; default: `t` or `time`, and the names
        of quantities.

    Returns
    -------
    dict
        Arrays of one length, missing values NaN.

    Raises
    ------
    ValueError
        With all faults, a sentence each with its line.

    Examples
    --------
    >>> from percuss.model.units import Units
    >>> columns = columns_of_text("Time (ms);x [mm]\n0;1,5\n10;2\n", Units("m", "s"))
    >>> {name: values.tolist() for name, values in columns.items()}
    {'t': [0.0, 0.01], 'displacement': [0.0015, 0.002]}
    """
    titles, separator, rows = _table_of_text(text, columns or {})
    head, rows = _with_units_below(_columns_in(titles, columns or {}), rows)
    faults = _faults_of_head(head, titles, columns or {})
    factors = []
    for column in head:
        factor, fault = factor_of(column, units)
        factors.append(factor)
        faults += [fault] if fault else []
    values, wrong = _numbers(head, rows, separator, len(titles))
    faults += wrong
    times = [i for i, column in enumerate(head) if column.quantity == "t"]
    if not faults and times:
        faults = _twice(values[:, times[0]], [line for line, _ in rows])
    if not faults and not rows:
        faults = ["no line of values under a line of names"]
    if faults:
        raise ValueError(_all_of(faults))
    return {column.quantity: converted(values[:, i], factors[i]) for i, column in enumerate(head)}


def forces_of_text(
    text: str,
    units: Units | None = None,
    time: str = "t",
    force: str = "f",
    *,
    quantity: str = "stop_force",
    has_omega: bool = False,
    has_amplitude: bool = False,
) -> tuple[Floats, Floats]:
    r"""Return instants and forces of a record in a table, each sample of which is a number.

    Parameters
    ----------
    text, units
        As `columns_of_text` takes them.
    time, force
        Names of the columns, with their units or without.
    quantity
        "stop_force", "force" or "acceleration": what the unit of the second column is of.
    has_omega
        Whether the first column holds phases, whatever its unit.
    has_amplitude
        Whether a factor is given, which makes forces of another quantity.

    Raises
    ------
    ValueError
        With all faults, a sentence each with its line.

    Examples
    --------
    >>> from percuss.model.units import Units
    >>> t, f = forces_of_text("t (ms);f [kN]\n0;1,5\n10;2\n", Units("m", "s", "kg"))
    >>> t.tolist(), f.tolist()
    ([0.0, 0.01], [1500.0, 2000.0])
    """
    names = {"t": time, "force": force}
    titles, separator, rows = _table_of_text(text, names)
    wanted = [column for column in _columns_in(titles, names) if column.quantity in names]
    head, rows = _with_units_below(wanted, rows)
    faults = _faults_of_names(head, titles, names)
    factors = {"t": 1.0, "force": 1.0}
    for column in head if not faults else []:
        if column.quantity == "t":
            factor, fault = (1.0, "") if has_omega else factor_of(column, units)
        else:
            factor, fault = force_factor(column, units, quantity, has_amplitude=has_amplitude)
        factors[column.quantity] = factor
        faults += [fault] if fault else []
    if not faults:
        values, faults = _numbers(head, rows, separator, len(titles))
        at = [column.quantity for column in head]
        for i, j in np.argwhere(np.isnan(values)).tolist():
            line, cells = rows[i]
            # Of a line that is too short that is told.
            if len(cells) > max(column.place for column in head):
                cell = cells[head[j].place]
                faults.append(f'line {line}: {head[j].title} = "{cell}" is no finite number')
        t, f = (values[:, at.index(name)] for name in names)
        if len(t) == len(rows):
            faults += _faults_of_order(t, [line for line, _ in rows], time)
        faults.sort(key=_line_of)
    if faults:
        raise ValueError(_all_of(faults))
    return converted(t, factors["t"]), converted(f, factors["force"])


def titles_of_text(text: str) -> list[str]:
    r"""Return the names of all columns of a table, those in the line above the first numbers.

    Examples
    --------
    >>> titles_of_text("Logger 7\n\nZeit [s];Kraft [kN];Notiz\n0;1,5;an\n")
    ['Zeit [s]', 'Kraft [kN]', 'Notiz']
    """
    return _titles_above_numbers(_lines_of(text))


def quantities_of_text(text: str) -> dict[str, str]:
    r"""Return the names of the columns of a table by the quantities that their names say.

    Where several say the same one it is left out.

    Examples
    --------
    >>> quantities_of_text("Time (ms);x [mm];v;vel;Temp\n0;1,5;1;1;20\n")
    {'t': 'Time (ms)', 'displacement': 'x [mm]'}
    """
    columns = _columns_in(titles_of_text(text), {})
    named = [column.quantity for column in columns]
    return {c.quantity: c.title for c in columns if named.count(c.quantity) == 1}


def _lines_of(text: str) -> list[tuple[int, str]]:
    """Return the lines of a table with their numbers, without empty ones and notes.

    The typographic minus, which spreadsheets in some languages write, is a minus.
    """
    return [
        (number, line)
        for number, line in enumerate(text.replace("\u2212", "-").splitlines(), 1)
        if line.strip() and not line.lstrip().startswith(NOTES)
    ]


def _titles_above_numbers(lines: Sequence[tuple[int, str]]) -> list[str]:
    """Return the cells of the line above the first one with numbers, of the separator that finds most."""
    best: list[str] = []
    most = 0, False
    for separator in SEPARATORS:
        rows = [_cells(line, separator) for _, line in lines[: MOST_LINES_ABOVE + 1]]
        for i, (above, row) in enumerate(pairwise(rows)):
            count = sum(map(_is_number, row))
            if count and not any(map(_is_number, above)):
                # A cell with a decimal comma is one number, not two: then the names are fewer.
                score = count, len(above) == len(row) > 1
                if score > most and (separator is not None or not most[0]):
                    is_below = i > 0 and len(rows[i - 1]) == len(above) and _are_units(above)
                    best, most = rows[i - 1] if is_below else above, score
                break
    return best


def _are_units(cells: Sequence[str]) -> bool:
    """Return whether cells are units, or empty, such as stand below the names of columns."""
    plain = [cell.strip("[]() ") for cell in cells]
    return any(plain) and all(cell in NO_UNIT or unit_of(cell, None) for cell in plain)


def _line_of(fault: str) -> int:
    """Return the line that a sentence begins with."""
    line = re.match(r"line (\d+)", fault)
    return int(line[1]) if line else 0


def _all_of(faults: Sequence[str]) -> str:
    more = [f"and {len(faults) - MOST_TOLD} more"] if len(faults) > MOST_TOLD else []
    return "; ".join([*faults[:MOST_TOLD], *more])


def _faults_of_names(
    head: Sequence[FileColumn], titles: Sequence[str], names: Mapping[str, str]
) -> list[str]:
    """Return the faults of columns that are asked for by name: missing, or there twice."""
    named = [column.quantity for column in head]
    missing = [f'"{name}"' for quantity, name in names.items() if quantity not in named]
    faults = [_no_such_columns(missing, titles)] if missing else []
    for quantity, name in names.items():
        if named.count(quantity) > 1:
            faults.append(f'"{name}" is the name of {named.count(quantity)} columns')
    return faults


def _no_such_columns(missing: Sequence[str], titles: Sequence[str]) -> str:
    return f"no column {', '.join(missing)}; its columns are {', '.join(titles)[:200]}"


def _faults_of_order(t: Floats, lines: Sequence[int], name: str) -> list[str]:
    """Return the faults of instants that do not rise, or are too few."""
    if len(t) < 2:
        count = "1 sample" if len(t) else "no samples"
        return [f"{count}; a record needs two at least"]
    # Where both are numbers: what is none is told already.
    steps = np.diff(np.where(np.isfinite(t), t, math.nan))
    if (steps < 0.0).all():
        return ["the samples are in reverse order, the last one first; turn the lines round"]
    faults = []
    for i in np.flatnonzero(steps <= 0.0).tolist():
        before, after = float(t[i]), float(t[i + 1])
        order = "is there twice" if after == before else f"comes after {before!r}"
        faults.append(f"line {lines[i + 1]}: {name} = {after!r} {order}; instants must rise")
    return faults


def _cells(line: str, separator: str | None) -> list[str]:
    if separator is None:
        return re.sub(r"\s+(?=[\[(])", "", line).split()
    try:
        return [cell.strip() for cell in next(csv.reader([line], delimiter=separator))]
    except (csv.Error, StopIteration):
        return [cell.strip() for cell in line.split(separator)]


def _columns_in(cells: Sequence[str], names: Mapping[str, str]) -> list[FileColumn]:
    """Return the columns that are read, of a line of names."""
    columns = []
    own = {name: quantity for quantity, name in names.items() if name}
    for place, cell in enumerate(cells):
        title, unit = name_and_unit(cell)
        quantity = quantity_named(title)
        # Another column may have been named for it.
        quantity = None if quantity in names else quantity
        for name, wanted in own.items():
            split = name_and_unit(cell, wanted)
            if name in (cell, split[0]):
                quantity, unit = wanted, split[1]
        if quantity is not None:
            columns.append(FileColumn(place, cell, quantity, unit))
    return columns


def _is_number(cell: str) -> bool:
    try:
        float(cell.replace(",", "."))
    except ValueError:
        return False
    return True


def _table_of_text(
    text: str, names: Mapping[str, str]
) -> tuple[list[str], str | None, list[NumberedRow]]:
    """Return the names of columns, what separates them, and the rows below the names."""
    lines = _lines_of(text)
    best: tuple[int, int, str | None] | None = None
    for i, (_, line) in enumerate(lines[:MOST_LINES_ABOVE]):
        for separator in SEPARATORS:
            cells = _cells(line, separator)
            count = len(_columns_in(cells, names))
            # A word of a sentence above the table is no name of a column, and neither is one of a
            # longer name, "Weg x", between other marks.
            is_other = separator is None and (len(cells) > 3 * count or ";" in line or "\t" in line)
            if count and not is_other and (best is None or count > best[0]):
                best = count, i, separator
    if best is None:
        raise ValueError(_no_columns(lines, names))
    _, at, separator = best
    titles = _cells(lines[at][1], separator)
    rows = [(number, _cells(line, separator)) for number, line in lines[at + 1 :]]
    return titles, separator, [(number, cells) for number, cells in rows if any(cells)]


def _no_columns(lines: Sequence[tuple[int, str]], names: Mapping[str, str]) -> str:
    """Return why there is no column that can be read."""
    wanted = ", ".join(f'"{name}"' for name in names.values() if name)
    wanted = wanted or f"t and one of {known_names()}"
    if not lines:
        return f"no column {wanted}; it is empty" if names else "the file is empty"
    titles = _titles_above_numbers(lines)
    if titles:
        return _no_such_columns([wanted], titles)
    line = lines[0][1]
    separator = max(SEPARATORS[:3], key=lambda sign: line.count(sign or ""))
    cells = _cells(line, separator if separator in line else None)
    if all(map(_is_number, cells)):
        return f"its first line holds numbers; write the names above them: {wanted}"
    return _no_such_columns([wanted], cells)


def _with_units_below(
    head: list[FileColumn], rows: list[NumberedRow]
) -> tuple[list[FileColumn], list[NumberedRow]]:
    """Return columns with the units of a line below their names, and the rows without that line."""
    if not rows:
        return head, rows
    cells = [cell.strip("[]() ") for cell in rows[0][1]]
    own = [cells[c.place] if c.place < len(cells) else "" for c in head]
    is_units = any(own) and all(
        cell in NO_UNIT or unit_of(cell, column.quantity) is not None
        for cell, column in zip(own, head, strict=True)
    )
    if not is_units or any(map(_is_number, own)):
        return head, rows
    return [
        FileColumn(c.place, c.title, c.quantity, c.unit or unit)
        for c, unit in zip(head, own, strict=True)
    ], rows[1:]


def _faults_of_head(
    head: Sequence[FileColumn], titles: Sequence[str], names: Mapping[str, str]
) -> list[str]:
    """Return what is wrong with the names of columns."""
    faults = []
    named = [column.quantity for column in head]
    for quantity in dict.fromkeys(named):
        twice = [column.title for column in head if column.quantity == quantity]
        if len(twice) > 1:
            listed = " and ".join(f'"{title}"' for title in twice)
            faults.append(f"{listed} are both {quantity}; keep one of them, or name it in columns")
    for title in dict.fromkeys(names.values()):
        wanted = [quantity for quantity, name in names.items() if name == title]
        if title and len(wanted) > 1:
            faults.append(f'"{title}" is named for {" and ".join(wanted)}')
            named += wanted
    for quantity, name in names.items():
        if name and quantity not in named:
            alike = closest(name, titles)
            hint = f'no column "{name}"; did you mean "{alike}"?' if alike else ""
            faults.append(hint or _no_such_columns([f'"{name}"'], titles))
    for title in titles:
        # A typing error would otherwise leave a column out without a word.
        plain = name_and_unit(title)[0].lower()
        close = difflib.get_close_matches(plain, POWERS, n=1, cutoff=0.85)
        if close and title not in [column.title for column in head] and close[0] not in names:
            place = f'; of a structure it is named in columns, {plain} = "{title}"'
            more = place if kind_of(plain) != plain else ""
            faults.append(f'column "{title}": did you mean "{close[0]}"?{more}')
    if faults:
        return faults
    listed = f"; its columns are {', '.join(titles)[:200]}"
    quantities = [name for name in named if name not in ("t", "noise")]
    if not quantities:
        return [f"no column of {known_names()}{listed}"]
    if "t" not in named and quantities != ["impact_times"]:
        return [f"no column of instants, t or time{listed}"]
    return []


def _numbers(
    head: Sequence[FileColumn], rows: Sequence[NumberedRow], separator: str | None, width: int
) -> tuple[Floats, list[str]]:
    """Return the numbers of the columns that are read, and the faults by their lines."""
    with_commas = separator != "," and any(
        _DECIMAL_COMMA.fullmatch(cell) for _, cells in rows[:1000] for cell in cells
    )
    values = np.full((len(rows), len(head)), math.nan)
    faults: list[str] = []
    least = 1 + max((column.place for column in head), default=0)
    for i, (line, cells) in enumerate(rows):
        if len(cells) < least:
            faults.append(_of_another_width(line, cells, width, separator))
            continue
        if any(cells[width:]):
            wrong = _of_another_width(line, cells, width, separator)
            faults.append(wrong + (OTHER_SEPARATOR if separator == "," else ""))
            # Of the lines below nothing is known.
            values = values[:i]
            break
        for j, column in enumerate(head):
            cell = cells[column.place]
            if cell.lower() in MISSING:
                continue
            number = cell.replace(",", ".") if with_commas else cell
            # What Python alone takes for a number, as 1_0, is none of a table.
            is_plain = number.isascii() and "_" not in number
            try:
                values[i, j] = float(number) if is_plain else math.inf
            except ValueError:
                values[i, j] = math.inf
            is_marked = "," in cell or with_commas
            if is_marked and _OF_THOUSANDS.fullmatch(cell):
                values[i, j] = math.inf
                reason = "has another decimal sign than other numbers; remove marks of thousands"
                faults.append(f'line {line}: {column.title} = "{cell[:30]}" {reason}')
            elif math.isinf(values[i, j]):
                hint = (
                    OTHER_SEPARATOR if separator == "," and _DECIMAL_COMMA.fullmatch(cell) else ""
                )
                wrong = f'line {line}: {column.title} = "{cell[:30]}" is no finite number'
                faults.append(wrong + hint)
    at = [column.quantity for column in head]
    if "t" in at and not faults:
        t = values[:, at.index("t")]
        others = [j for j, name in enumerate(at) if name not in ("t", "noise", "impact_times")]
        lost = np.isnan(t) & np.isfinite(values[:, others]).any(axis=1)
        faults += [
            f"line {rows[i][0]}: a value without its instant" for i in np.flatnonzero(lost).tolist()
        ]
    return values, faults


def _twice(t: Floats, lines: Sequence[int]) -> list[str]:
    """Return the fault of instants that are there more than once: a clock that is too coarse."""
    order = np.argsort(t, kind="stable")
    same = np.flatnonzero(np.diff(t[order]) == 0.0)
    if not len(same):
        return []
    first, second = (lines[order[int(same[0]) + k]] for k in (0, 1))
    at = float(t[order[int(same[0])]])
    more = f", and {len(same) - 1} more" if len(same) > 1 else ""
    return [f"line {second}: the instant {at:.10g} of line {first} is there again{more}"]


def _of_another_width(line: int, cells: Sequence[str], width: int, separator: str | None) -> str:
    count = counted(len(cells), "cell")
    return f"line {line}: {count} between {NAMED[separator]}, where the names have {width}"
