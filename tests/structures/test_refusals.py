"""What takes oscillators alone says so of a structure, and names what takes one."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

import percuss as pc
import percuss.plotting as pp

TWO = pc.chain([1, 1], [1, 1, 0], "0.1", [pc.Wall("0.5", "above", "0.7", on=1)])
LOADS = pc.Loads({0: pc.cosine("0.9", amplitude="0.3")})


@pytest.fixture(scope="module")
def orbit() -> pc.StructureOrbit:
    return pc.find_orbit(TWO, LOADS)


@pytest.mark.parametrize("name", ["impact_map", "stroboscopic_map", "singularity_set"])
def test_what_takes_oscillators_names_what_takes_structures(name: str) -> None:
    with pytest.raises(pc.ParameterError, match="oscillators alone; structures are taken by simul"):
        getattr(pc, name)(TWO, LOADS)


def test_each_function_that_is_named_takes_structures() -> None:
    with pytest.raises(pc.ParameterError) as refused:
        pc.impact_map(TWO, LOADS)  # type: ignore[arg-type]

    words = str(refused.value).split("taken by ")[1].replace(" and ", ", ")
    assert all(hasattr(pc, name) for name in words.split(", "))


CALLS: dict[str, Callable[[Any], Any]] = {
    "of a structure; follow each doubling": lambda orbit: pc.follow_cascade(
        orbit, over={"loads.0.omega": (0.8, 1.0)}
    ),
    "not the run of an oscillator or of a structure": pc.spectrum,
    "a structure has several resonant frequencies": lambda orbit: pp.plot_staircase(orbit.run),
    "not a Manifolds": pp.plot_manifolds,
}


@pytest.mark.parametrize("sentence", CALLS)
def test_what_is_not_there_is_told(sentence: str, orbit: pc.StructureOrbit) -> None:
    with pytest.raises(pc.ParameterError, match=sentence):
        CALLS[sentence](orbit)


def test_pictures_of_a_run_take_an_orbit(orbit: pc.StructureOrbit) -> None:
    for plot in (
        pp.plot_displacement,
        pp.plot_velocity,
        pp.plot_phase_portrait,
        pp.plot_impact_velocities,
    ):
        own, other = (plot(one, on=(1, -1)) for one in (orbit, orbit.run))
        assert len(own.get_children()) == len(other.get_children()) > 10


@pytest.mark.parametrize("given", [{"n_impacts": 0}, {"sequence": [0]}, {"formal": True}])
def test_how_orbits_of_structures_are_found_takes_no_more(given: dict[str, Any]) -> None:
    with pytest.raises(pc.ParameterError, match="of a structure the orbit near a guess is found"):
        pc.find_orbit(TWO, LOADS, **given)


def test_what_structures_lack_is_one_sentence() -> None:
    pair = pc.Structure([1, 1], [[2, -1], [-1, 2]])
    with pytest.raises(pc.ParameterError, match=r"t_end = None: needed for a structure"):
        pc.simulate(pair, x0=[1, 0])
    with pytest.raises(pc.ParameterError, match="results of structures have no certificates"):
        pc.certify(pc.simulate(pair, x0=[1, 0], t_end=1))  # type: ignore[call-overload]
