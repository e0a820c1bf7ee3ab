"""Complete lists of orbits: against the float engine, and against lists that would be wrong."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pytest
from flint import arb

import percuss as pc
from percuss.certified import list_orbits
from percuss.certified.ball_arithmetic import Undecided
from percuss.certified.cloud import Cloud
from percuss.certified.covering import ImpactSurface
from percuss.certified.numbers import precision
from percuss.certified.return_equations import ReturnEquations, SurfaceBox
from percuss.certified.shooting import events_of
from percuss.certified.system import system_of
from percuss.plotting import plot_enclosure

SYMMETRIC = (pc.Wall("0.3", "above", "0.7"), pc.Wall("-0.3", "below", "0.7"))
SYSTEMS = {
    "COCO": (pc.impact_oscillator("0.8"), pc.cosine("2.8")),
    "gap": (
        pc.impact_oscillator("0.7", wall="1.45789", side="above", damping="0.05"),
        pc.cosine("1.5"),
    ),
    "two walls": (pc.Oscillator(1, "0.02", SYMMETRIC), pc.cosine("1.5")),
    "soft stop": (pc.Oscillator(1, "0.05", (pc.SoftStop("0.5", "above", 20, "0.1"),)),
                  pc.cosine("1.7")),
    "two tones": (pc.impact_oscillator("0.6", wall="-0.2", damping="0.1"),
                  pc.fourier("1.3", cos=[1, "0.7"])),
}  # fmt: skip


@pytest.mark.parametrize(
    ("name", "periods"), [("COCO", 1), ("COCO", 2), ("gap", 1), ("two tones", 1)]
)
def test_all_orbits_with_one_impact_are_those_of_the_closed_form(name: str, periods: int) -> None:
    osc, force = SYSTEMS[name]
    known = [
        orbit
        for orbit in pc.find_orbits(osc, force, 1, periods)
        if (orbit.n_impacts, orbit.n_periods) == (1, periods)
    ]

    found = list_orbits(osc, force, 1, periods, speeds=("0.02", 5))

    assert found.complete
    assert found.reason == ""
    wanted = [orbit for orbit in known if 0.02 <= abs(float(orbit.impacts.v_after[0])) <= 5.0]
    assert len(found) == len(wanted)
    for orbit in wanted:
        (ours,) = [o for o in found.orbits if abs(o.v0.mid() - orbit.v0) < 1e-9]
        assert ours.stability == orbit.stability
        assert ours.admissible is True


def test_all_orbits_with_two_impacts_with_the_shorter_one_that_is_run_through_twice() -> None:
    found = list_orbits(*SYSTEMS["COCO"], 2, 2, speeds=("0.2", 2))

    assert found.complete
    assert len(found) == len(found.shorter) == 1
    assert found.orbits[0].min_impact_speed.mid() == pytest.approx(0.44459, abs=1e-5)
    assert found.shorter[0].n_impacts == 1
    assert len(found.boxes) == 3


@pytest.mark.parametrize(
    ("cycle", "numbers"),
    [(("0.81", "0.84"), (1, 0)), (("0.975", 1), (0, 1)), (("0.84", "0.86"), (0, 0))],
)
def test_orbits_with_two_impacts_in_a_part_of_the_cycle(
    cycle: tuple[str, str], numbers: tuple[int, int]
) -> None:
    found = list_orbits(*SYSTEMS["COCO"], 2, 2, speeds=("0.26", "0.4"), cycle=cycle)

    assert found.complete
    assert (len(found), len(found.shorter)) == numbers
    assert list(found.to_pandas().stability) == ["unstable"] * numbers[0]


def test_orbits_in_another_part_of_the_cycle_or_slower_are_not_listed() -> None:
    osc, force = SYSTEMS["gap"]
    both = list_orbits(osc, force, speeds=("0.5", 3))
    cycles = sorted(orbit.impacts.cycle[0].mid() for orbit in both.orbits)
    one = list_orbits(osc, force, speeds=("0.5", 3), cycle=(0, "0.3"))
    fast = list_orbits(osc, force, speeds=("2.5", 3))

    assert len(both) == 2
    assert cycles[0] < 0.3 < cycles[1]
    assert [orbit.impacts.cycle[0].mid() for orbit in one.orbits] == [cycles[0]]
    assert len(fast) == 1
    assert one.complete
    assert fast.complete


def test_a_list_that_was_not_finished_says_where_an_orbit_may_be() -> None:
    osc, force = SYSTEMS["COCO"]
    orbit = pc.find_orbit(osc, force)
    c, v = float(orbit.impacts.cycle[0]), float(orbit.impacts.v_after[0])

    found = list_orbits(osc, force, speeds=("0.1", 2), most_boxes=8)

    assert not found.complete
    assert not found.orbits
    assert "perhaps not all" in repr(found)
    assert 0.0 < found.open_part <= 1.0 + 1e-12
    a, b, low, high = found.open_boxes.T
    assert ((a < c) & (c < b) & (low < v) & (v < high)).any()


def test_an_elastic_family_is_open_and_no_list() -> None:
    # Each motion of a stretch of starts comes back: no list of finitely many is complete.
    found = list_orbits(
        pc.impact_oscillator(), pc.sine(3), 3, 3, speeds=("0.55", "0.75"), most_boxes=300
    )

    assert not found.complete


@pytest.mark.parametrize("name", list(SYSTEMS))
def test_no_box_around_an_orbit_is_ever_excluded(name: str) -> None:
    """The attack: boxes of all sizes around orbits that the float engine knows, and near them."""
    osc, force = SYSTEMS[name]
    rng = np.random.default_rng(5)
    n_looked_at = 0
    for orbit in pc.find_orbits(osc, force, 3, 2):
        rows = np.flatnonzero(orbit.impacts.stop == 0)
        if np.isinf(orbit.n_impacts) or not rows.size:
            continue
        with precision(64):
            system = system_of(osc, force)
            event = next(event for event in events_of(system, orbit) if event.stop == 0)
            slowest = 0.999 * min(abs(v) for v in orbit.itinerary.velocities.tolist())
            equations = ReturnEquations(
                ImpactSurface(system, event), rows.size, orbit.n_periods, slowest, 100.0
            )
            for row in rows:
                t, v = float(orbit.impacts.t[row]), float(orbit.impacts.v_after[row])
                for half in 10.0 ** rng.uniform(-9.0, -0.5, 8):
                    by = half * rng.uniform(0.1, 1.0, 4)
                    box = SurfaceBox(t - by[0], t + by[1], v - by[2], v + by[3])
                    if not equations.off * (v - equations.off * by.max()) > 0.0:
                        continue
                    n_looked_at += 1
                    assert not equations.excludes(box)
                    try:
                        missed = equations.missed(box)
                    except Undecided:
                        continue
                    assert missed is not None
                    assert not missed.has_no_root()
                    inverse = missed.inverse()
                    if inverse is not None:
                        inside = missed.krawczyk(inverse)
                        place = t - missed.middle[0], v - missed.middle[1]
                        assert all(
                            (a + arb(0, 1e-9)).contains(b)
                            for a, b in zip(inside, place, strict=True)
                        )
    assert n_looked_at > 5


def test_what_misses_itself_is_what_the_float_map_says() -> None:
    osc, force = SYSTEMS["COCO"]
    step = pc.impact_map(osc, force)
    period = 2.0 * np.pi / 2.8
    with precision(64):
        system = system_of(osc, force)
        event = events_of(system, pc.find_orbit(osc, force))[0]
        surface = ImpactSurface(system, event)
        for t, v in [(0.3, 0.7), (1.9, 0.4), (1.2, 1.1)]:
            image = surface.image(Cloud.of(arb(t), arb(v)))
            cycle, after = step(t / period, v)
            at = float(image.middle[0]) / period % 1.0
            assert at == pytest.approx(float(cycle), abs=1e-12)
            assert float(image.middle[1]) == pytest.approx(float(after), abs=1e-12)


def test_a_picture_shows_orbits_their_boxes_and_what_is_open() -> None:
    mpl.use("agg")
    osc, force = SYSTEMS["COCO"]
    axes = plot_enclosure(list_orbits(osc, force, speeds=("0.1", 2)))
    assert "complete" in axes.get_title()
    assert axes.get_legend_handles_labels()[1] == ["one solution, proven", "unstable"]
    axes = plot_enclosure(list_orbits(*SYSTEMS["gap"], speeds=("0.1", 2), most_boxes=5))
    assert "of the region is open" in axes.get_title()
    assert axes.get_ylim() == (-2.0, -0.1)


def test_a_list_is_saved_as_a_table(tmp_path: Path) -> None:
    found = list_orbits(*SYSTEMS["gap"], speeds=("0.1", 5))
    pc.save_csv(found.to_xarray(), tmp_path / "orbits.csv")
    text = (tmp_path / "orbits.csv").read_text(encoding="utf-8").splitlines()
    assert text[0].startswith("orbit,cycle,cycle_radius,v_after")
    assert len(text) == 3


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"speeds": (0, 1)}, "reaches to 0, where impacts graze"),
        ({"speeds": (2, 1)}, "the first is not below the second"),
        ({"speeds": (1,)}, "not two numbers"),
        ({"cycle": (0, 2)}, "not within 0 and 1"),
        ({"stop": 3}, "the oscillator has 1 stop"),
        ({"impacts": 0}, "impacts"),
        ({"force": None}, "a list of orbits needs a periodic forcing"),
        ({"force": pc.square_wave(2)}, "record"),
    ],
)
def test_bad_input_is_refused_in_a_sentence(given: dict[str, object], words: str) -> None:
    osc, force = SYSTEMS["COCO"]
    arguments: dict[str, object] = {"osc": osc, "force": force, "speeds": (Fraction(1, 2), 1)}
    with pytest.raises(pc.ParameterError, match=words):
        list_orbits(**{**arguments, **given})  # type: ignore[arg-type]
