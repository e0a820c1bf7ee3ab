"""The names of axes: of a parameter in words with its symbol, with its unit where it has one."""

from __future__ import annotations

import re

import xarray as xr
from matplotlib.axes import Axes

from percuss.model.dimensions import dimensions_of
from percuss.model.forcing import Forcing
from percuss.model.loads import Loads
from percuss.model.oscillator import Oscillator
from percuss.model.structure import Structure
from percuss.model.units import CYCLES, Units, is_unit
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit
from percuss.orbits.orbit.structure_orbit import StructureOrbit

NAMES = {
    "oscillator.stiffness": "stiffness $k$",
    "oscillator.damping": "damping $a$",
    "oscillator.damping_coefficient": "damping $c$",
    "oscillator.mass": "mass $m$",
    "forcing.constant": "constant force",
    "forcing.amplitude": "forcing amplitude",
    "forcing.omega": r"forcing frequency $\omega$",
    "forcing.phase": r"forcing phase $\varphi$",
    "forcing.period": "forcing period $T$",
    "forcing.record.amplitude": "amplitude of the record",
    "forcing.record.omega": r"frequency of the record $\omega$",
    "start.x0": "initial displacement $x_0$",
    "start.v0": "initial velocity $v_0$",
    "start.t0": "initial time $t_0$",
}
OF_STOP = {
    "at": "place",
    "restitution": "restitution $r$",
    "stiffness": "stiffness",
    "damping": "damping",
}
STOP = re.compile(r"(?:oscillator|structure)\.stops\.(\d+)\.(\w+)")
TABLE = re.compile(r"oscillator\.stops\.(\d+)\.restitution\.(speed|value)s\.(\d+)")
START = re.compile(r"start\.([xv])0\.(\d+)")
LOAD = re.compile(r"loads\.(\d+)\.(.+)")
HARMONIC = re.compile(r"forcing\.harmonics\.(\d+)\.(\w+)")
TERM = re.compile(r"forcing\.(cos|sin)\.(\d+)")
EXPONENT = re.compile(r"\^(\d+)")
POWER = re.compile(r"(length|time|mass)(?:\^(\d+))?")


def parameter_name(path: str, n_stops: int = 1, n_harmonics: int = 1, n_loads: int = 1) -> str:
    r"""Return the name of a parameter in words, with its symbol; an own name as it is.

    Examples
    --------
    >>> parameter_name("forcing.harmonics.0.omega"), parameter_name("w")
    ('forcing frequency $\\omega$', 'w')
    >>> parameter_name("oscillator.stops.1.at", n_stops=2)
    'place of stop 1'
    >>> parameter_name("loads.1.amplitude", n_loads=2)
    'forcing amplitude of load 1'
    >>> parameter_name("start.x0.3")
    'initial displacement $x_{3}$'
    """
    if entry := START.fullmatch(path):
        what = {"x": "displacement", "v": "velocity"}[entry[1]]
        return f"initial {what} ${entry[1]}_{{{entry[2]}}}$"
    if load := LOAD.fullmatch(path):
        name = parameter_name(f"forcing.{load[2]}", n_stops, n_harmonics)
        return name if n_loads == 1 else f"{name} of load {load[1]}"
    if (of_stop := STOP.fullmatch(path)) and of_stop[2] in OF_STOP:
        which = "the stop" if n_stops == 1 else f"stop {of_stop[1]}"
        return f"{OF_STOP[of_stop[2]]} of {which}"
    if entry := TABLE.fullmatch(path):
        which = "the stop" if n_stops == 1 else f"stop {entry[1]}"
        return f"{entry[2]} {entry[3]} of the restitution of {which}"
    if part := HARMONIC.fullmatch(path):
        name = NAMES.get(f"forcing.{part[2]}", path)
        return name if n_harmonics == 1 else f"{name}, harmonic {part[1]}"
    if term := TERM.fullmatch(path):
        return f"coefficient of {term[1]} {int(term[2]) + 1}"
    return NAMES.get(path, path)


def with_unit(name: str, dimensions: str, units: Units | None) -> str:
    """Return the name of a quantity with its unit, or with "(dimensionless)" where it has none.

    Parameters
    ----------
    name
        The name.
    dimensions
        In length, time and mass, or the unit itself; "1", or empty where they are not known.
    units
        The units; None: none at all.

    Examples
    --------
    >>> with_unit("force", "mass length/time^2", Units("m", "s", "t"))
    'force (kN)'
    >>> with_unit("acceleration", "length/time^2", Units("m", "s"))
    'acceleration (m/s$^{2}$)'
    >>> with_unit("force", "length/time^2", None), with_unit("force", "length/time^2", Units("mm"))
    ('force (dimensionless)', 'force (mm)')
    >>> with_unit("rate", "1/time", Units("m", "s")), with_unit("period", "1", None)
    ('rate (1/s)', 'period')
    >>> with_unit("f", "cycle/time", Units("m", "s")), with_unit("f", "cycle/time", None)
    ('f (Hz)', 'f (dimensionless)')
    """
    if dimensions in ("", "1"):
        return name
    if dimensions == "rad" or is_unit(dimensions):
        return f"{name} ({_raised(dimensions)})"
    given = units or Units()
    parts = []
    for side in dimensions.split("/"):
        kept = (match[0] for match in POWER.finditer(side) if getattr(given, match[1]))
        parts.append(" ".join(kept))
    known = "/".join([parts[0] or "1", *filter(None, parts[1:])])
    if dimensions == CYCLES and given.time:
        known = CYCLES
    return f"{name} ({'dimensionless' if known == '1' else _raised(given.of(known))})"


def _raised(unit: str) -> str:
    """Return a unit with its exponents as pictures show them."""
    return EXPONENT.sub(r"$^{\1}$", unit)


def label_axes(ax: Axes, data: xr.Dataset, across: str, upwards: str, units: Units) -> None:
    """Name both axes after the parameters that they carry."""
    ax.set_xlabel(path_label(data, across, units))
    ax.set_ylabel(path_label(data, upwards, units))


def path_label(data: xr.Dataset, path: str, units: Units | None) -> str:
    r"""Return the label of an axis over a parameter of a table.

    Examples
    --------
    >>> forcing = {"forcing": "Forcing(harmonics=(Harmonic(amplitude=1.0, omega=2.5, phase=0.0),))"}
    >>> path = "forcing.harmonics.0.omega"
    >>> path_label(xr.Dataset(coords={path: [2.0]}, attrs=forcing), path, None)
    'forcing frequency $\\omega$'
    """
    # Which stop, and which harmonic, is said where there are several.
    oscillator, forcing = (str(data.attrs.get(key, "")) for key in ("oscillator", "forcing"))
    n_stops = oscillator.count("Wall(") + oscillator.count("SoftStop(")
    is_massive = path == "oscillator.damping" and "mass=" in oscillator.split("stops=")[0]
    path_of_name = "oscillator.damping_coefficient" if is_massive else path
    name = parameter_name(path_of_name, n_stops, forcing.count("Harmonic("))
    return with_unit(name, str(data[path].attrs.get("units", "")), units)


def parameter_label(orbit: PeriodicOrbit | StructureOrbit, path: str, units: Units) -> str:
    """Return the label of an axis over the parameter of a branch or a curve of such orbits."""
    if isinstance(orbit, StructureOrbit):
        return label_of(orbit.structure, orbit.loads, path, units)
    return label_of(*orbit.system, path, units)


def label_of(
    model: Oscillator | Structure, force: Forcing | Loads | None, path: str, units: Units
) -> str:
    r"""Return the label of an axis over a parameter of a model or of what drives it.

    Examples
    --------
    >>> import percuss as pc
    >>> label_of(pc.impact_oscillator(), pc.cosine(2), "start.v0", Units("m", "s"))
    'initial velocity $v_0$ (m/s)'
    """
    dimensions = dimensions_of(path, model, force)
    if "." not in path:
        return with_unit(path, dimensions, units)
    if path == "oscillator.damping" and isinstance(model, Oscillator) and model.mass is not None:
        # c of a mass, not a of a unit mass.
        path = "oscillator.damping_coefficient"
    load, n_loads = LOAD.fullmatch(path), 1
    if isinstance(force, Loads):
        n_loads = len(force.forcings)
        force = force.forcings[int(load[1])] if load else None
    n_harmonics = 0 if force is None else len(force.harmonics)
    name = parameter_name(path, len(model.stops), n_harmonics, n_loads)
    return with_unit(name, dimensions, units)
