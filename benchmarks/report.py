"""What was measured, printed as it comes and written as Markdown."""

from __future__ import annotations

import datetime
import importlib.metadata
import os
import platform
import re
from dataclasses import dataclass, field
from pathlib import Path

PACKAGES = ("percuss", "numpy", "numba", "heyoka", "scipy", "mpmath")
HEADER = """\
# Benchmarks

Written by `python benchmarks/run.py --write docs/benchmarks.md` on {date}.

{cpu}, {cores} cores of which one is used; {system}; Python {python}; {versions}.

Times are medians of seven runs (of three at least where seven would take over 20 s), without the
first; contenders of one table take turns, and a ratio is the quotient of the medians that stand
above it, before they were rounded. Every answer is asserted, a time never is: a target
that is missed stands in the last column. `benchmarks/` says what exactly each line measures.
"""


@dataclass(frozen=True)
class Line:
    """One measured quantity; ``met`` is None without a target."""

    quantity: str
    value: str
    target: str
    met: bool | None


@dataclass
class Section:
    """A table with its title and what the reader must know."""

    title: str
    note: str
    lines: list[Line] = field(default_factory=list)


@dataclass
class Report:
    """The tables of all benchmarks that ran."""

    sections: list[Section] = field(default_factory=list)

    def section(self, title: str, note: str = "") -> None:
        """Begin a table."""
        self.sections.append(Section(title, note))
        print(f"\n{title}" + (f"\n{note}" if note else ""), flush=True)

    def line(self, quantity: str, value: str, target: str = "", *, met: bool | None = None) -> None:
        """Add a line to the last table."""
        self.sections[-1].lines.append(Line(quantity, value, target, met))
        print(f"  {quantity:<58} {value:>24}   {target:<18} {_verdict(met)}", flush=True)

    def below(self, quantity: str, value: float, limit: float, unit: str) -> None:
        """Add a line whose value should not exceed a limit."""
        shown = f"{value:,.0f}" if value >= 1000.0 else f"{value:.3g}"
        self.line(quantity, f"{shown} {unit}", f"<= {limit:g} {unit}", met=value <= limit)

    def ratio(self, quantity: str, value: float, least: float | None = None) -> None:
        """Add a line that says how many times as long a peer takes."""
        target = "" if least is None else f">= {least:g}x"
        met = None if least is None else value >= least
        self.line(quantity, f"{value:,.1f}x", target, met=met)

    def markdown(self) -> str:
        """Return all tables with machine, versions and date."""
        parts = [_header()]
        for section in self.sections:
            parts += [f"\n## {section.title}\n"]
            parts += [f"\n{section.note}\n"] if section.note else []
            parts += ["\n| | | target | |\n|---|---:|---|---|\n"]
            parts += [
                f"| {line.quantity} | {line.value} | {line.target} | {_verdict(line.met)} |\n"
                for line in section.lines
            ]
        return "".join(parts)


def _verdict(met: bool | None) -> str:
    return {True: "met", False: "missed", None: ""}[met]


def _header() -> str:
    return HEADER.format(
        date=datetime.datetime.now(datetime.UTC).date(),
        cpu=_cpu(),
        cores=os.cpu_count(),
        system=platform.system(),
        python=platform.python_version(),
        versions=", ".join(
            f"{name} {version}" for name in PACKAGES if (version := installed(name)) is not None
        ),
    )


def installed(name: str) -> str | None:
    """Return the version of an installed distribution, None if there is none."""
    try:
        return importlib.metadata.version(name)
    except importlib.metadata.PackageNotFoundError:
        return None


def _cpu() -> str:
    info = Path("/proc/cpuinfo")
    found = re.search(r"model name\s*: (.*)", info.read_text()) if info.exists() else None
    return found[1] if found else platform.processor() or platform.machine()
