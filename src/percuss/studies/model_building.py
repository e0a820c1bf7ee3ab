"""The tables of the model to the model, with every fault that it finds in them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from percuss.errors import ParameterError
from percuss.model.faults import Fault, damping_faults, draft, faults, positive_faults
from percuss.model.forcing import Forcing
from percuss.model.harmonics import FourierTerm, Harmonic
from percuss.model.oscillator import Oscillator
from percuss.model.stops import SoftStop, Wall
from percuss.studies.faults import shown
from percuss.studies.parts import MISSING, Table, add_faults, drafted, exact_phase, rows_of
from percuss.studies.shape import Found
from percuss.studies.study import EngineersModel

__all__ = ["engineers_model", "forcing_of", "oscillator_of", "per_mass"]

_FOURIER = ("omega", "cos", "sin")
_DAMPINGS = ("damping_coefficient", "damping_ratio")


def oscillator_of(table: Table, found: Found) -> Oscillator:
    """Return the oscillator of a table, a draft where it has faults."""
    stops = tuple(_stop(row) for row in rows_of(table, "stops"))
    values = {"stiffness": 1.0, "damping": 0.0}
    values = {name: table.get(name, value) for name, value in values.items()}
    oscillator = draft(Oscillator, **values, stops=stops)
    add_faults(faults(oscillator, "oscillator"), found)
    return oscillator


def engineers_model(
    table: Table, oscillator: Oscillator, forcing: Forcing | None, found: Found
) -> EngineersModel | None:
    """Return the model in engineers' units if a mass is given and nothing is wrong with it."""
    dampings = {name: table[name] for name in _DAMPINGS if name in table}
    if "mass" not in table:
        for name in dampings:
            found.add(
                ("oscillator", name), "needs oscillator.mass; mass = 1 leaves all else as it is"
            )
        return None
    add_faults(positive_faults("oscillator.mass", table["mass"]), found)
    for name, value in dampings.items():
        add_faults(damping_faults(f"oscillator.{name}", value), found)
    if "stiffness" not in table:
        found.add(("oscillator", "stiffness"), "missing; with a mass it has no default")
    if "damping" in table:
        reason = "given together with mass; give damping_coefficient or damping_ratio"
        found.add(("oscillator", "damping"), reason, shown(table["damping"]))
    if found.is_wrong("oscillator") or found.is_wrong("forcing"):
        return None
    return EngineersModel(
        table["mass"], table["stiffness"], **dampings, stops=oscillator.stops, forcing=forcing
    )


def per_mass(given: EngineersModel, found: Found) -> tuple[Oscillator, Forcing | None]:
    """Return the oscillator and the forcing of unit mass; add what the division makes wrong."""
    oscillator, forcing = Oscillator(stops=given.stops), given.forcing
    owner = "oscillator"
    try:
        oscillator = given.oscillator()
        owner = "forcing"
        forcing = given.forcing_per_mass()
    except ParameterError as error:
        if error.name in _DAMPINGS:
            add_faults([Fault(f"{owner}.{error.name}", error.value, error.reason)], found)
        else:
            reason = f"after the division by it, {owner}.{error.name} is {error.reason}"
            found.add(("oscillator", "mass"), reason, shown(given.mass))
    return oscillator, forcing


def _stop(row: Any) -> Wall | SoftStop:
    needed = {"at": MISSING, "side": MISSING}
    kind = row.get("type") if isinstance(row, Mapping) else None
    if kind == "soft":
        return drafted(SoftStop, row, {**needed, "stiffness": MISSING, "damping": 0.0})
    # What is neither has a fault already; as a wall without a place it gets no second one.
    return drafted(Wall, row, {**needed, "restitution": 1.0})


def forcing_of(table: Table, found: Found) -> Forcing:
    """Return the forcing of a table, a draft where it has faults."""
    constant, period = table.get("constant", 0.0), table.get("period")
    given = [name for name in _FOURIER if name in table]
    if not given:
        defaults = {"amplitude": MISSING, "omega": MISSING, "phase": 0.0}
        harmonics = tuple(_harmonic(row, defaults) for row in rows_of(table, "harmonics"))
        forcing = draft(Forcing, harmonics=harmonics, constant=constant, period=exact_phase(period))
    else:
        for name in ("harmonics", "period"):
            if name in table:
                reason = f"given together with {given[0]}; omega, cos and sin stand alone"
                found.add(("forcing", name), reason)
        if "omega" not in table:
            found.add(("forcing", "omega"), "missing; cos and sin need the base frequency")
        forcing = _fourier(table, constant)
    add_faults(faults(forcing, "forcing"), found)
    return forcing


def _harmonic(row: Any, defaults: Table) -> Harmonic:
    given = dict(row) if isinstance(row, Mapping) else {}
    if "phase" in given:
        given["phase"] = exact_phase(given["phase"])
    return drafted(Harmonic, given, defaults)


def _fourier(table: Table, constant: Any) -> Forcing:
    cos, sin = rows_of(table, "cos"), rows_of(table, "sin")
    count = max(len(cos), len(sin))
    pairs = zip(*(values + [0.0] * (count - len(values)) for values in (cos, sin)), strict=True)
    terms = tuple(draft(FourierTerm, n=n, cos=c, sin=s) for n, (c, s) in enumerate(pairs, 1))
    base = table.get("omega", MISSING)
    return draft(Forcing, harmonics=terms, constant=constant, base=base)
