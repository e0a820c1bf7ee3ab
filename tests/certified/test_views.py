from __future__ import annotations

import copy
import pickle
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from flint import arb, ctx
from tests.certified.motions import ELASTIC, chaotic

import percuss as pc
from percuss.certified import CertifiedRun
from percuss.errors import ParameterError


def test_samples_and_text_show_the_enclosure() -> None:
    proven = pc.certify(pc.simulate(ELASTIC, pc.sine(3), v0=1, t_end=9.0))

    data = proven.sample(7)

    assert dict(data.sizes) == {"t": 7}
    assert float(data.x_radius.max()) < 1e-12
    assert "proven up to t_end" in repr(proven)
    assert proven.impacts.t[0].text(10).startswith("3.14159265") or "3.1415" in repr(
        proven.impacts.t[0]
    )


def test_a_stroboscopic_view_is_at_exact_periods() -> None:
    run = pc.simulate(pc.impact_oscillator("0.8"), pc.cosine("2.5"), v0=0.6, t_end=40.0)

    ours, theirs = pc.certify(run).stroboscopic(), run.stroboscopic()

    assert dict(ours.sizes) == dict(theirs.sizes)
    np.testing.assert_allclose(ours.x, theirs.x, atol=1e-12)
    np.testing.assert_allclose(ours.v, theirs.v, atol=1e-12)
    assert float(ours.x_radius.max()) < 1e-14
    with pytest.raises(ParameterError, match="period"):
        pc.certify(pc.simulate(ELASTIC, v0=1, t_end=3.0)).stroboscopic()


def test_floats_of_known_times_are_inside_of_what_is_proven() -> None:
    # The end is a ball narrower than a float's rounding.
    for run in (chaotic(60), pc.simulate(ELASTIC, pc.sine(3), v0=1, t0="2*pi", max_impacts=2)):
        few = pc.certify(run, bits=40)
        assert few.sample(3).sizes == {"t": 3}
        proven = pc.certify(run)

        low, high = proven.known_times

        assert 0.0 <= low - run.t0 < 1e-14
        assert arb(high) < proven.t_end.arb
        assert proven.t_end.mid() - high < 1e-12
        assert proven.sample(3).sizes == {"t": 3}


def test_times_are_taken_as_exactly_as_they_are_given() -> None:
    proven = pc.certify(pc.simulate(pc.Oscillator(), v0=1, t_end=3.0), digits=30)

    times: list[Any] = [Fraction(1, 3), "pi/2", pc.pi_times(1, 6), 0.1, np.float32(0.5)]
    x, _ = proven(times)

    assert x[1].contains(1)
    assert x[2].contains("1/2")
    with ctx.workprec(300):
        assert x[0].arb.overlaps((arb(1) / 3).sin())
        assert x[3].arb.overlaps(arb(0.1).sin())
        assert not x[3].arb.overlaps(arb("0.1").sin())
        assert x[4].arb.overlaps(arb("0.5").sin())
    assert proven([[0.5], [1.0]])[0].mid().shape == (2, 1)
    assert proven("1/3")[0].mid().shape == ()


def test_forces_and_energy_are_those_of_the_float_run() -> None:
    osc = pc.Oscillator("1.5", "0.1", (pc.Wall(0, "below", "1/2"),
                                       pc.SoftStop("0.4", "above", 20, "0.3")))  # fmt: skip
    run = pc.simulate(osc, pc.cosine("1.3", constant="-0.6"), x0="0.2", v0=1, t_end=20.0)
    proven = pc.certify(run)
    assert len(proven.contacts) > 0
    assert len(proven.crossings) > 1
    times = np.linspace(0.1, 19.9, 300)

    ours, theirs = proven.forces(times), run.forces(times)

    for name in ("spring", "damping", "forcing", "stops"):
        assert ours[name].dims == theirs[name].dims
        np.testing.assert_allclose(ours[name], theirs[name], rtol=0, atol=1e-10)
    assert float(ours.stops_radius.max()) < 1e-14
    assert float(abs(theirs.stops[0]).max()) > 0.1
    np.testing.assert_allclose(proven.energy(times).mid(), run.energy(times), rtol=0, atol=1e-11)
    assert proven.energy(times.reshape(30, 10)).radius().shape == (30, 10)


def test_forces_at_the_edge_of_a_contact_are_those_of_both_sides() -> None:
    # A ball of v = 2 under gravity 1, r = 1/2, rests from t = 8 on, as nearly as it is known.
    run = pc.simulate(pc.Oscillator(0, stops=(pc.Wall(0, "below", "1/2"),)),
                      pc.Forcing(constant=-1), v0=2, t_end=9.0)  # fmt: skip
    stops, radius = (
        pc.certify(run).forces([7.0, 8.0, 8.5])[name][0] for name in ("stops", "stops_radius")
    )

    np.testing.assert_allclose(stops, [0.0, 0.5, 1.0], atol=1e-9)
    np.testing.assert_allclose(radius, [0.0, 0.5, 0.0], atol=1e-9)


def test_tables_are_datasets_with_radii() -> None:
    proven = pc.certify(chaotic(5))

    data = proven.impacts.to_xarray()

    np.testing.assert_array_equal(data.t, proven.impacts.t.mid())
    np.testing.assert_array_equal(data.v_after_radius, proven.impacts.v_after.radius())
    assert data.t_radius.long_name == "radius of the time of the impact"
    assert set(chaotic(5).impacts.to_xarray()) <= set(data)
    for table in (proven.crossings, proven.contacts, proven.grazes):
        assert set(table.to_xarray().sizes.values()) == {0}
    assert "<th>t_radius</th>" in proven.impacts._repr_html_()


def test_events_of_runs_and_orbits_have_times() -> None:
    run = pc.certify(chaotic(5))
    orbit = pc.certify(pc.find_orbit(pc.impact_oscillator("0.8"), pc.cosine("2.5")))

    assert run.event_times[0].mid() == run.start_time.mid()
    assert list(run.event_times.mid()[1:]) == list(run.impacts.t.mid())
    assert list(orbit.event_times.mid()) == list(orbit.impacts.t.mid())
    x, _ = orbit(["1/3", "pi"])
    assert x[0].overlaps(orbit("1/3")[0][0])


def test_a_part_of_a_column_is_a_column() -> None:
    t = pc.certify(chaotic(5)).impacts.t

    assert [ball.mid() for ball in t[1:3]] == list(t.mid()[1:3])
    assert t[-1].mid() == t.mid()[4]


def test_results_can_be_pickled_and_copied() -> None:
    proven = pc.certify(chaotic(5))

    for again in (pickle.loads(pickle.dumps(proven)), copy.deepcopy(proven)):
        assert isinstance(again, CertifiedRun)
        assert repr(again) == repr(proven)
        for ours, theirs in zip(again.impacts.t.arbs, proven.impacts.t.arbs, strict=True):
            assert ours.mid() == theirs.mid()
            # Their radius has 30 bits, and is rounded up.
            assert theirs.rad() <= ours.rad() <= theirs.rad() * (1 + 2.0**-26)
        assert again(2.0)[0][0].overlaps(proven(2.0)[0][0])
    none = pickle.loads(pickle.dumps([arb.nan(), arb.pos_inf(), arb.neg_inf(), arb(0, "inf")]))
    assert none[0].is_nan()
    assert none[1] == arb.pos_inf()
    assert none[2] == arb.neg_inf()
    assert none[3].contains(1e300)
    assert not none[3].is_nan()
