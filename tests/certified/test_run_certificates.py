"""Runs that percuss proves, another program proves again."""

from __future__ import annotations

import copy
import json
from fractions import Fraction

import pytest
from tests.certified.checker import (
    NINES,
    SOFT,
    WALL,
    Claims,
    assert_refused,
    by_name,
    changed,
    chosen,
    leaves,
    run_of,
    theorem_of,
    two_walls,
)

import percuss as pc
from percuss.certified import certificate
from percuss.errors import ParameterError
from theorems import theorem

TWO_WALLS = pc.Oscillator(
    1,
    damping="1/50",
    stops=(
        pc.Wall(at="-1/2", side="below", restitution="3/5"),
        pc.Wall(at="1/2", side="above", restitution="7/10"),
    ),
)
BALL = pc.Oscillator(0, stops=(pc.Wall(at=0, side="below", restitution="4/5"),))
TWO_TONES = pc.cosine(1, amplitude="1/2", phase="pi/3") + pc.cosine("3/2", amplitude="1/5")


@pytest.mark.parametrize(
    ("osc", "force", "start"),
    [
        (WALL, pc.cosine("14/5"), {"v0": "1/2", "max_impacts": 12}),
        (TWO_WALLS, TWO_TONES, {"x0": "1/10", "t0": "pi/7", "max_impacts": 9}),
        (TWO_WALLS, pc.cosine(1), {"x0": "1/2", "v0": "-1/5", "max_impacts": 6}),
        (SOFT, pc.cosine("11/10", constant="1/10"), {"v0": "1/2", "t_end": 20}),
        (BALL, pc.cosine(3, amplitude=2, constant=-10), {"x0": 1, "max_impacts": 5}),
        (BALL, pc.Forcing(constant=-10), {"x0": 1, "max_impacts": 8}),
        (pc.impact_oscillator("9/10", wall=1, side="above"), pc.cosine(1), {"max_impacts": 6}),
        (
            pc.Oscillator(-1, damping="1/10", stops=TWO_WALLS.stops),
            pc.cosine(2),
            {"v0": "1/3", "max_impacts": 8},
        ),
        (
            pc.Oscillator(0, damping="1/3", stops=TWO_WALLS.stops),
            pc.cosine(2, constant="1/4"),
            {"v0": 1, "max_impacts": 6},
        ),
        (
            pc.Oscillator(4, damping=2, stops=(pc.Wall(at=0, side="below", restitution="1/2"),)),
            pc.cosine(2, amplitude=3),
            {"v0": 1, "max_impacts": 5},
        ),
    ],
    ids=[
        "chaos",
        "two walls, two tones",
        "start on a wall",
        "soft stop",
        "ball on a table",
        "free fall",
        "resonance",
        "unstable spring",
        "no spring",
        "critical damping",
    ],
)
def test_runs_in_every_regime_are_proven_again(
    osc: pc.Oscillator, force: pc.Forcing, start: Claims
) -> None:
    proven = run_of(osc, force, **start)

    words = theorem_of(certificate(proven))

    n = len(proven.impacts) + len(proven.crossings)
    assert n > 4
    assert f"at {n} instants and no others" in words


@pytest.mark.parametrize("n", [40, pytest.param(200, marks=pytest.mark.nightly)])
def test_a_long_chaotic_run_is_proven_again(n: int) -> None:
    proven = run_of(WALL, pc.cosine("14/5"), v0="1/2", max_impacts=n)

    assert f"at {n} instants" in theorem_of(certificate(proven))


@by_name
def test_a_run_that_is_changed_anywhere_is_refused(run: Claims, by_name: bool) -> None:
    theorem_of(run)
    places = chosen(leaves(run), by_name)

    assert len(places) > (20 if by_name else 50)
    for path in places:
        assert_refused(changed(run, path))


def test_a_run_may_have_tones_that_are_none() -> None:
    for force in (
        pc.cosine("14/5") + pc.cosine(1, amplitude=0),
        pc.cosine("14/5") + pc.cosine(1, amplitude="1/3") + pc.cosine(1, amplitude="-1/3"),
    ):
        claims = certificate(run_of(WALL, force, v0="1/2", max_impacts=4))
        assert "at 4 instants" in theorem_of(claims)


def test_wide_claims_and_long_numbers_are_told(run: Claims) -> None:
    other = copy.deepcopy(run)
    other["events"] = other["events"][:1]
    for name in ("t", "v_before", "v_after"):
        other["events"][0][name] = [f"-{NINES}", f"{NINES}"]
    # 1/20 and a little.
    other["law"]["regions"][0]["damping"] = f"5{'0' * 1996}1/1{'0' * 1999}"

    assert f"-{NINES}" in theorem_of(other)


def test_a_start_into_a_wall_begins_behind_its_impact() -> None:
    claims = certificate(run_of(WALL, pc.cosine("14/5"), v0=-1, max_impacts=4))

    assert claims["start"] == {"x": "0", "v": "4/5", "t": ["0", "0"]}
    assert "at 3 instants" in theorem_of(claims)
    with pytest.raises(ParameterError, match="the run meets no stop after its start"):
        certificate(run_of(WALL, pc.cosine("14/5"), v0=-1, t_end="1/100"))


def claimed(upper: str, bound: int, t: tuple[float, float], speed: float) -> str:
    v = sorted(Fraction(speed) + d for d in (Fraction(-1, 100), Fraction(1, 100)))
    w = sorted(-part / 2 for part in v)
    event = {
        name: [str(Fraction(end)) for end in pair]
        for name, pair in (("t", t), ("v_before", v), ("v_after", w))
    }
    return json.dumps(
        {
            "certificate": 1,
            "kind": "run",
            "law": two_walls(upper),
            "start": {"x": "0", "v": "1", "t": ["0", "0"]},
            "events": [{"bound": bound, **event}],
        }
    )


@pytest.mark.parametrize("off", [Fraction(1, 10**6), Fraction(1, 10**12), Fraction(1, 10**15)])
def test_a_wall_missed_or_touched_by_a_hair_is_told_apart(off: Fraction) -> None:
    miss, touch = str(1 + off), str(1 - off)
    beyond = (3.6, 3.7), -0.866
    before = (1.56, 1.5708), 0.0

    assert "PROVEN" not in theorem(claimed(miss, 0, *beyond))
    assert "1 instants" in theorem(claimed(touch, 1, *before))
    for upper, bound, claim in ((miss, 1, before), (touch, 0, beyond)):
        assert_refused(claimed(upper, bound, *claim))


def test_a_graze_is_left_open() -> None:
    assert_refused(claimed("1", 0, (3.6, 3.7), -0.866), "which event comes next is open")


@pytest.mark.parametrize("off", ["1/10000", "1/1000000000000", "0"])
def test_a_run_next_to_resonance_is_proven_again(off: str) -> None:
    osc = pc.Oscillator(
        Fraction(1) + Fraction(off), stops=(pc.Wall(at=0, side="below", restitution="4/5"),)
    )
    proven = run_of(osc, pc.cosine(1), v0=1, max_impacts=4)

    assert "at 4 instants" in theorem_of(certificate(proven))


def test_a_start_at_rest_on_a_stop_is_proven_if_the_force_lifts_it_off() -> None:
    claims = certificate(run_of(WALL, pc.cosine("14/5"), max_impacts=3))
    assert claims["start"] == {"x": "0", "v": "0", "t": ["0", "0"]}

    assert "at 3 instants" in theorem_of(claims)
    for t in (["1", "0"], ["5/28", "0"]):
        assert_refused(
            claims | {"start": {"x": "0", "v": "0", "t": t}}, "beyond a wall, or stays on a stop"
        )


def test_an_event_left_out_is_missed(run: Claims) -> None:
    for k in range(len(run["events"]) - 1):
        events = run["events"][:k] + run["events"][k + 1 :]
        assert_refused(run | {"events": events})
    assert "no others" in theorem_of(run | {"events": run["events"][:-1]})
