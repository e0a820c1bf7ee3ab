"""Structures to begin with: their parameters with ranges of sliders, and what they are made of."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from percuss.arrays import Floats
from percuss.model.exact import Exact, as_float
from percuss.model.forcing import Forcing
from percuss.model.harmonic_forces import cosine
from percuss.model.loads import Loads
from percuss.model.mechanisms import chain, impact_pair, vibro_impact_absorber
from percuss.model.oscillator import Oscillator, SoftStop, Stop, Wall
from percuss.model.structure import Structure
from percuss.model.structure_start import StructureStart

# A part of the largest entry of a matrix that is no joint, but rounding of its sums.
NO_JOINT = 1e-12
MechanismValues = Mapping[str, Exact]


@dataclass(frozen=True, slots=True)
class Call:
    """A call of the library: what it returns, and the same as Python.

    Parameters
    ----------
    function
        A public function or class of `percuss`.
    arguments
        Its arguments by name; calls among them, alone or in lists, are made first.

    Examples
    --------
    >>> call = Call(cosine, {"omega": "1.2", "amplitude": 2})
    >>> call.made().period.__round__(3), call
    (5.236, pc.cosine(omega='1.2', amplitude=2))
    """

    function: Callable[..., Any]
    arguments: Mapping[str, Any]

    def made(self) -> Any:
        """Return what the call returns."""
        return self.function(**{name: _made(value) for name, value in self.arguments.items()})

    def __repr__(self) -> str:
        rows = ", ".join(f"{name}={value!r}" for name, value in self.arguments.items())
        return f"pc.{self.function.__name__}({rows})"

    def lines(self) -> list[str]:
        """Return the call as lines of Python, an argument on each."""
        rows = [f"    {name}={value!r}," for name, value in self.arguments.items()]
        return [f"pc.{self.function.__name__}(", *rows, ")"]


def _made(value: Any) -> Any:
    if isinstance(value, list):
        return [_made(part) for part in value]
    return value.made() if isinstance(value, Call) else value


@dataclass(frozen=True, slots=True)
class Parameter:
    """A parameter of a mechanism, a slider of the page.

    Parameters
    ----------
    path
        Its name, that of the argument of the library.
    group
        Group of sliders in which it stands.
    label, about
        What it is called, and what it is.
    value
        Value at first.
    high, low
        Ends of the slider.
    """

    path: str
    group: str
    label: str
    about: str
    value: Exact
    high: float
    low: float = 0.0


@dataclass(frozen=True, slots=True)
class Mechanism:
    """A structure of two or three masses whose parameters have names.

    Parameters
    ----------
    name, title, caption
        Its key, its name, and what it is in a sentence.
    parameters
        Its parameters; those of the loads, the start and the length come after those of the model.
    build
        Returns the call that makes the structure for values of the parameters.
    """

    name: str
    title: str
    caption: str
    parameters: tuple[Parameter, ...]
    build: Callable[[MechanismValues], Call]

    @property
    def defaults(self) -> dict[str, Exact]:
        """Values at first, by path."""
        return {parameter.path: parameter.value for parameter in self.parameters}

    def system(self, values: MechanismValues) -> tuple[Structure, Loads, StructureStart]:
        """Return the structure, its loads and the start for values of all parameters.

        Raises
        ------
        ParameterError
            If a value is outside its domain; its name is the path of the parameter.
        """
        structure = self.build(values).made()
        x0, v0 = self._start(values)
        return structure, Loads({0: _force(values).made()}), StructureStart(x0, v0)

    def python(self, values: MechanismValues) -> str:
        """Return a script that follows and draws the motion, every number as it was given.

        Examples
        --------
        >>> pair = MECHANISMS["impact_pair"]
        >>> print(pair.python(pair.defaults))
        import percuss as pc
        <BLANKLINE>
        structure = pc.impact_pair(
            masses=(1, '0.5'),
            gap='0.5',
            restitution='0.7',
            springs=(1, 0, 0),
            dashpots=('0.1', '0.02', 0),
        )
        loads = pc.Loads({0: pc.cosine(omega='1.2', amplitude='0.5')})
        run = pc.simulate(structure, loads, x0=(0, 0), v0=(0, 0), periods=60)
        print(run)
        run.sample(4000).x.plot.line(x="t")
        <BLANKLINE>
        """
        first, *rest = self.build(values).lines()
        x0, v0 = self._start(values)
        given = f"x0={x0!r}, v0={v0!r}, periods={values['periods']!r}"
        return "\n".join(
            [
                "import percuss as pc",
                "",
                f"structure = {first}",
                *rest,
                f"loads = pc.Loads({{0: {_force(values)!r}}})",
                f"run = pc.simulate(structure, loads, {given})",
                "print(run)",
                'run.sample(4000).x.plot.line(x="t")',
                "",
            ]
        )

    def _start(self, values: MechanismValues) -> tuple[tuple[Exact, ...], tuple[Exact, ...]]:
        n = sum(path.startswith("v.") for path in self.defaults)
        return _along(values, "x", n), _along(values, "v", n)


def _force(values: MechanismValues) -> Call:
    return Call(cosine, {"omega": values["omega"], "amplitude": values["amplitude"]})


_START = "Start and length"


def _model(path: str, label: str, about: str, value: Exact, high: float) -> Parameter:
    return Parameter(path, "Structure", label, about, value, high)


def _driven(amplitude: Exact, omega: Exact, periods: int, n: int) -> tuple[Parameter, ...]:
    """Return the parameters of the force on the first mass, the start and the length."""
    high, fast = 3.0 * as_float(amplitude), 3.0 * as_float(omega)
    return (
        Parameter("amplitude", "Force on mass 1", "amplitude", "of the force", amplitude, high),
        Parameter("omega", "Force on mass 1", "omega", "angular frequency", omega, fast, 0.05),
        *(
            Parameter(f"{letter}.{i}", _START, f"{letter}{i + 1}", f"{what} {i + 1}", 0, 2.0, -2.0)
            for letter, what in (("x", "displacement of mass"), ("v", "velocity of mass"))
            for i in range(n)
        ),
        Parameter("periods", _START, "periods", "of the force, followed", periods, 400.0, 2.0),
    )


def _masses(*values: Exact) -> tuple[Parameter, ...]:
    return tuple(
        _model(f"masses.{i}", f"mass m{i + 1}", f"of mass {i + 1}", value, 3.0 * as_float(value))
        for i, value in enumerate(values)
    )


def _joints(kind: str, letter: str, *values: Exact) -> tuple[Parameter, ...]:
    """Return the parameters of springs or dashpots from the ground along the masses."""
    n = len(values)
    ends = ["ground", *(f"mass {i + 1}" for i in range(n - 1)), "ground"]
    return tuple(
        _model(
            f"{kind}s.{i}",
            f"{kind} {letter}{i + 1}",
            f"from {ends[i]} to {ends[i + 1]}",
            value,
            max(1.0 if kind == "spring" else 0.2, 3.0 * as_float(value)),
        )
        for i, value in enumerate(values)
    )


def _along(values: MechanismValues, kind: str, n: int) -> tuple[Exact, ...]:
    return tuple(values[f"{kind}.{i}"] for i in range(n))


def _row(values: MechanismValues, n: int) -> dict[str, Any]:
    """Return the arguments of masses in a row with a spring and a dashpot on either side."""
    return {
        "masses": _along(values, "masses", n),
        "springs": _along(values, "springs", n + 1),
        "dashpots": _along(values, "dashpots", n + 1),
    }


def _pair(values: MechanismValues) -> Call:
    own = {"gap": values["gap"], "restitution": values["restitution"]}
    row = _row(values, 2)
    return Call(impact_pair, {"masses": row.pop("masses"), **own, **row})


def _stop(at: Exact, on: object, **rest: Exact) -> Call:
    kind = Wall if "restitution" in rest else SoftStop
    return Call(kind, {"at": at, "side": "above", **rest, "on": on})


def _two(values: MechanismValues) -> Call:
    stop = _stop(values["at"], 1, stiffness=values["stiffness"], damping=values["damping"])
    return Call(chain, {**_row(values, 2), "stops": [stop]})


def _absorber(values: MechanismValues) -> Call:
    names = ("mass", "stiffness", "absorber_mass", "gap", "restitution", "damping")
    return Call(
        vibro_impact_absorber, {name: values[name] for name in (*names, "absorber_damping")}
    )


def _three(values: MechanismValues) -> Call:
    stops = [
        _stop(values["at"], 2, restitution=values["restitution"]),
        _stop(values["gap"], (1, -1, 0), stiffness=values["stiffness"]),
    ]
    return Call(chain, {**_row(values, 3), "stops": stops})


_GAP = "from the middle of the cavity to either wall"
_BOUNCE = ("restitution", "restitution r", "1: no loss; 0: it stays")

MECHANISMS = {
    mechanism.name: mechanism
    for mechanism in (
        Mechanism(
            "impact_pair",
            "Impact pair",
            "A mass rattles in a cavity of another one, which a spring holds and a force drives.",
            (
                *_masses(1, "0.5"),
                *_joints("spring", "k", 1, 0, 0),
                *_joints("dashpot", "c", "0.1", "0.02", 0),
                _model("gap", "gap", _GAP, "0.5", 2.0),
                _model(*_BOUNCE, "0.7", 1.0),
                *_driven("0.5", "1.2", 60, 2),
            ),
            _pair,
        ),
        Mechanism(
            "two_masses",
            "Two masses with a stop",
            "Two masses between three springs; the second one meets a soft stop.",
            (
                *_masses(1, 1),
                *_joints("spring", "k", 1, 1, 1),
                *_joints("dashpot", "c", "0.05", "0.05", "0.05"),
                _model("at", "gap", "from the second mass at rest to the stop", "0.5", 2.0),
                _model("stiffness", "stop k", "stiffness of the stop", 20, 60.0),
                _model("damping", "stop c", "dashpot of the stop", "0.2", 2.0),
                *_driven("0.4", "1.1", 60, 2),
            ),
            _two,
        ),
        Mechanism(
            "absorber",
            "Vibro-impact absorber",
            "The first mode of a beam, and a small mass in a cavity of it that takes its energy.",
            (
                _model("mass", "beam mass", "modal mass of the beam", 1, 3.0),
                _model("stiffness", "beam k", "modal stiffness of the beam", 1, 3.0),
                _model("damping", "beam c", "dashpot of the beam", "0.02", 0.2),
                _model("absorber_mass", "absorber m", "mass of the absorber", "0.05", 0.3),
                _model("absorber_damping", "absorber c", "dashpot between the two", 0, 0.2),
                _model("gap", "gap", _GAP, "0.5", 2.0),
                _model(*_BOUNCE, "0.65", 1.0),
                *_driven("0.1", "0.95", 100, 2),
            ),
            _absorber,
        ),
        Mechanism(
            "three_masses",
            "Three masses, two stops",
            "The first two masses meet at a soft stop between them, the third one hits a wall.",
            (
                *_masses(1, "0.6", "0.8"),
                *_joints("spring", "k", 1, 2, 1, 1),
                *_joints("dashpot", "c", "0.05", "0.05", "0.05", "0.05"),
                _model("at", "wall gap", "from the third mass at rest to the wall", "0.4", 2.0),
                _model(*_BOUNCE, "0.7", 1.0),
                _model("gap", "middle gap", "between the first two masses at rest", "0.2", 1.0),
                _model(
                    "stiffness",
                    "stop k",
                    "stiffness of the soft stop between the first two",
                    20,
                    60.0,
                ),
                *_driven("0.6", "0.9", 60, 3),
            ),
            _three,
        ),
    )
}


def elements_of(structure: Structure, loads: Loads) -> dict[str, object]:
    """Return what a picture of a structure of masses in a row is drawn from.

    Parameters
    ----------
    structure
        With a diagonal mass matrix: each coordinate is the displacement of a mass.
    loads
        Its loads.

    Returns
    -------
    dict
        `n`, the number of masses; `springs` and `dashpots`, pairs of masses, -1 for the ground;
        `stops` with what they act on, position, side and type; `loads`, their directions.

    Examples
    --------
    >>> import percuss as pc
    >>> elements_of(pc.chain([1, 1], [1, 2, 0]), pc.Loads())["springs"]
    [[-1, 0], [0, 1]]
    """
    rows = zip(structure.stops, structure.stop_directions, strict=True)
    return {
        "n": structure.n,
        "springs": _joined(structure.stiffness_matrix),
        "dashpots": _joined(structure.damping_matrix),
        "stops": [_stop_of(stop, c.tolist()) for stop, c in rows],
        "loads": loads.directions(structure).tolist(),
    }


def elements_of_oscillator(oscillator: Oscillator, force: Forcing | None) -> dict[str, object]:
    """Return what a picture of one mass is drawn from, as `elements_of` does of several.

    Parameters
    ----------
    oscillator
        The mass, its spring, dashpot and stops.
    force
        What drives it; an arrow shows it, against x where it is a negative constant alone.

    Returns
    -------
    dict
        The entries of `elements_of`.

    Examples
    --------
    >>> import percuss as pc
    >>> made = elements_of_oscillator(pc.impact_oscillator(stiffness=0), pc.Forcing(constant=-1))
    >>> made["springs"], made["loads"], made["stops"][0]["side"]
    ([], [[-1.0]], 'below')
    """
    unit = oscillator.of_unit_mass()
    to_ground = [[-1, 0]]
    loads: list[list[float]] = []
    if force is not None:
        constant = as_float(force.constant)
        is_moving = bool(force.components()) or force.record is not None
        if is_moving or constant != 0.0:
            loads = [[-1.0 if constant < 0.0 and not is_moving else 1.0]]
    return {
        "n": 1,
        "springs": to_ground if as_float(unit.stiffness) != 0.0 else [],
        "dashpots": to_ground if as_float(unit.damping) != 0.0 else [],
        "stops": [_stop_of(stop, [1.0]) for stop in oscillator.stops],
        "loads": loads,
    }


def _stop_of(stop: Stop, on: list[float]) -> dict[str, object]:
    kind = "wall" if isinstance(stop, Wall) else "soft"
    return {"on": on, "at": as_float(stop.at), "side": stop.side, "type": kind}


def _joined(matrix: Floats) -> list[list[int]]:
    """Return the pairs of masses that a matrix joins, -1 for the ground."""
    least = NO_JOINT * float(np.abs(matrix).max(initial=0.0))
    n = len(matrix)
    ground = [[-1, i] for i in range(n) if abs(math.fsum(matrix[i])) > least]
    return ground + [
        [i, j] for i in range(n) for j in range(i + 1, n) if abs(float(matrix[i, j])) > least
    ]
