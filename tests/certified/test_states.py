from __future__ import annotations

import pytest
from flint import arb, ctx

import percuss as pc
from percuss.certified.cloud import Cloud
from percuss.certified.contact import Hops
from percuss.certified.march import Ending, MarchRecord, Piece
from percuss.certified.motion import state_at
from percuss.certified.step import Departure
from percuss.certified.system import BallSystem, system_of
from percuss.errors import ParameterError


def _record(*pieces: Piece, until: float = 3.0) -> MarchRecord:
    record = MarchRecord(ctx.prec)
    record.pieces += pieces
    record.until = arb(until)
    return record


def _free() -> BallSystem:
    return system_of(pc.Oscillator(), None)


def test_a_state_holds_those_of_all_starts_beside_the_middle() -> None:
    # x = sin(t - t0) from the origin at speed 1: at pi/2 the derivative by t0 is zero.
    start = Departure(0, Cloud.of(arb(0, 0.125), arb(1)), 0)
    record = _record(Piece(arb(0, 0.125), start))

    x, v = state_at(system_of(pc.impact_oscillator(), None), record, "pi/2")

    for t0 in (-0.125, -0.0625, 0.0, 0.125):
        since = arb.pi() / 2 - t0
        assert x.overlaps(since.sin())
        assert v.overlaps(since.cos())


def test_a_state_holds_those_of_all_pieces_that_may_have_begun() -> None:
    # Three pieces whose order is certain, but whose instants all lie within one another's radius.
    places = (1, 2, 3)
    starts = (arb(0), arb(1, 0.5), arb("1.25", 0.5))
    record = _record(
        *(Piece(t, Hops(t, arb(x), arb(0))) for t, x in zip(starts, places, strict=True))
    )

    assert state_at(_free(), record, 0.25)[0] == 1
    for x in (1, 2):
        assert state_at(_free(), record, 0.625)[0].contains(x)
    for x in places:
        assert state_at(_free(), record, 0.875)[0].contains(x)
    assert state_at(_free(), record, 2.5)[0] == 3


@pytest.mark.parametrize("ending", [Ending.graze, Ending.reached_max_impacts])
def test_a_proof_up_to_an_event_claims_nothing_within_its_radius(ending: Ending) -> None:
    record = _record(Piece(arb(0), Hops(arb(0), arb(1), arb(0))))
    record.until, record.ending = arb(2, 0.5), ending

    assert state_at(_free(), record, 1.25)[0] == 1
    with pytest.raises(ParameterError, match="outside of what is proven"):
        state_at(_free(), record, 1.75)
