"""Restitution that depends on the speed of the impact."""

from __future__ import annotations

import itertools
import math
import pickle
from pathlib import Path

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import percuss as pc
from percuss.errors import StudyError
from percuss.io.exact_json import decoded, encoded
from percuss.kernels.law_columns import FIRST_HARMONIC
from percuss.kernels.restitution import kept_of_error, restitution_at, speed_before
from percuss.model.restitution import restitution_knots
from percuss.model.system import System
from percuss.studies.reading import load_study, parse_study
from percuss.studies.running import run_study

STEEL = pc.restitution_table(speeds=("0.5", 1, 3), values=("0.9", "0.8", "0.6"))
FROM_REST = pc.restitution_table(speeds=(0, 2, 4), values=("0.7", "0.85", "0.6"))
FORCE = pc.cosine("2.8")
each_table = pytest.mark.parametrize("table", [STEEL, FROM_REST], ids=["constant", "from rest"])


def r_of(table: pc.model.RestitutionTable, speed: float) -> float:
    """Return the restitution by NumPy's interpolation."""
    speeds, values = np.array(restitution_knots(table), dtype=np.float64).T
    return float(np.interp(speed, speeds, values))


@each_table
def test_each_impact_has_the_restitution_of_its_speed(table: pc.model.RestitutionTable) -> None:
    run = pc.simulate(pc.impact_oscillator(table), FORCE, v0=4, periods=100)

    speeds = np.abs(run.impacts.v_before)
    kept = np.abs(run.impacts.v_after) / speeds

    assert speeds.min() < 0.5
    assert speeds.max() > 3.0
    expected = [r_of(table, speed) for speed in speeds]
    np.testing.assert_allclose(kept, expected, rtol=4e-15)


def test_a_table_of_one_value_is_that_restitution() -> None:
    same = pc.restitution_table([0, 1, 7], ["0.8"] * 3)
    one = pc.simulate(pc.impact_oscillator("0.8"), FORCE, v0=1, periods=20)

    run = pc.simulate(pc.impact_oscillator(same), FORCE, v0=1, periods=20)

    np.testing.assert_allclose(run.impacts.t, one.impacts.t, rtol=1e-9)


def ball_until_rest(table: pc.model.RestitutionTable, height: float) -> mpmath.mpf:
    """Return when a ball dropped from a height comes to rest under unit gravity, by its hops."""
    with mpmath.workdps(40):
        knots = [(mpmath.mpf(float(u)), mpmath.mpf(float(r))) for u, r in restitution_knots(table)]
        speed = mpmath.sqrt(2 * mpmath.mpf(height))
        t = speed
        while speed > mpmath.mpf(10) ** -30:
            r = knots[-1][1]
            if speed <= knots[0][0]:
                r = knots[0][1]
            for (u0, r0), (u1, r1) in itertools.pairwise(knots):
                if u0 <= speed <= u1:
                    r = r0 + (r1 - r0) * (speed - u0) / (u1 - u0)
            speed *= r
            t += 2 * speed
        return t


@each_table
@pytest.mark.parametrize("height", [0.01, 1.0, 30.0])
def test_a_ball_comes_to_rest_when_all_its_hops_are_over(
    table: pc.model.RestitutionTable, height: float
) -> None:
    osc, force = pc.impact_oscillator(table, stiffness=0), pc.Forcing(constant=-1)

    run = pc.simulate(osc, force, x0=height, t_end=1e3)

    exact = ball_until_rest(table, height)
    assert run.outcome is pc.Outcome.at_rest
    assert abs(float(exact - run.contacts.start[0])) <= run.contacts.error_bound[0] < 1e-8


def test_impacts_below_an_elastic_speed_go_on_for_ever() -> None:
    """A mass that loses energy only above a speed keeps that speed."""
    table = pc.restitution_table(["0.5", 1], [1, "0.8"])
    run = pc.simulate(pc.impact_oscillator(table), v0=3, max_impacts=2000)

    assert len(run.contacts) == 0
    assert abs(run.impacts.v_after[-1]) == pytest.approx(0.5, abs=1e-2)
    assert run.impacts.t[-1] == pytest.approx(2000 * math.pi, rel=1e-13)


@each_table
@pytest.mark.parametrize("damping", [0.0, 0.3])
def test_derivative_of_a_motion_is_that_of_neighbours(
    table: pc.model.RestitutionTable, damping: float
) -> None:
    osc = pc.impact_oscillator(table, damping=damping)
    image = pc.impact_map(osc, FORCE)
    for cycle, v in ((0.1, 1.7), (0.4, 0.7), (0.8, 2.6)):
        exact = image.jacobian(cycle, v)
        h = 1e-6
        columns = [
            (np.array(image(cycle + dc, v + dv)) - np.array(image(cycle - dc, v - dv))) / (2 * h)
            for dc, dv in ((h, 0.0), (0.0, h))
        ]
        np.testing.assert_allclose(exact, np.stack(columns, axis=-1), rtol=1e-6, atol=1e-7)


def test_an_orbit_is_found_continued_and_has_its_multipliers() -> None:
    osc = pc.impact_oscillator(STEEL, wall=1, side="above", damping="0.05")
    orbit = pc.find_orbit(osc, pc.cosine(1))

    (u,), (w,) = np.abs(orbit.impacts.v_before), np.abs(orbit.impacts.v_after)
    assert w / u == pytest.approx(r_of(STEEL, u), rel=1e-13)
    # r(u) u has the derivative r + r' u, where the table falls by 0.1 a unit of speed.
    slope = -0.1 if u > 1 else -0.2
    area = w / u * (w / u + slope * u) * math.exp(-0.1 * orbit.period)
    assert float(np.prod(orbit.multipliers).real) == pytest.approx(area, rel=1e-12)
    assert np.linalg.det(orbit.monodromy) == pytest.approx(area, rel=1e-9)
    branch = pc.continue_orbit(orbit, over={"forcing.amplitude": (0.2, 3)})
    for point in (branch[0], branch[-1]):
        again = pc.find_orbit(osc, point.forcing, guess=point)
        assert again.impacts.v_before == pytest.approx(point.impacts.v_before, rel=1e-12)
        for before, after in zip(point.impacts.v_before, point.impacts.v_after, strict=True):
            assert -after / before == pytest.approx(r_of(STEEL, abs(before)), rel=1e-12)


@pytest.mark.parametrize("speeds", [("0.2", 2), (0, 2)], ids=["constant", "from rest"])
def test_a_motion_settles_on_the_orbit_with_sticking(speeds: tuple[float, ...]) -> None:
    osc = pc.impact_oscillator(pc.restitution_table(speeds, ("0.3", "0.2")))
    force = pc.cosine(1, constant="-0.3")

    orbit = pc.find_orbit(osc, force, n_impacts=math.inf)
    run = pc.simulate(osc, force, v0=1, periods=40)

    late = (run.contacts.start[-1] - orbit.trajectory(2).contacts.start) / orbit.period
    assert np.abs(late - np.round(late)).min() < 1e-11
    assert run.contacts.error_bound[-1] < 1e-8


def test_exponents_keep_their_sum_rule() -> None:
    osc = pc.impact_oscillator(STEEL, wall="0.2", side="above", damping="0.05")
    exponents = pc.lyapunov_exponents(osc, pc.cosine("2.5"), periods=500)
    run = pc.simulate(osc, pc.cosine("2.5"), periods=2000)

    logs = []
    for u in np.abs(run.impacts.v_before):
        slope = -0.2 if 0.5 < u < 1 else -0.1 if 1 < u < 3 else 0.0
        logs.append(math.log(r_of(STEEL, u) * (r_of(STEEL, u) + slope * u)))
    mean = sum(logs) / run.t_end - 0.1
    assert float(exponents.exponents.sum()) == pytest.approx(mean, rel=0.05)


@given(
    speed=st.floats(0.0, 10.0),
    rises=st.lists(st.tuples(st.floats(0.05, 2.0), st.floats(0.05, 1.0)), min_size=1, max_size=5),
    rests=st.booleans(),
)
def test_the_speed_before_an_impact_is_found_from_that_after(
    speed: float, rises: list[tuple[float, float]], *, rests: bool
) -> None:
    """A fall from r at u to less than r u1 / (2 u1 - u) at u1 would let the speed after fall."""
    u, r, speeds, values = 0.0, 0.7, [], []
    for du, share in rises:
        # Between half of the steepest fall and the steepest rise to 1.
        least = r * (u + du) / (u + 2.0 * du)
        u, r = u + du, least + share * (1.0 - least)
        speeds.append(u)
        values.append(r)
    if rests:
        speeds, values = [0.0, *speeds], [0.7, *values]
    osc = pc.impact_oscillator(pc.restitution_table(speeds, values))
    law = System(osc, None).law

    after = restitution_at(law, FIRST_HARMONIC, 0, speed) * speed

    assert speed_before(law, FIRST_HARMONIC, 0, after) == pytest.approx(speed, rel=1e-12)
    assert kept_of_error(law, FIRST_HARMONIC, 0, speed) > 0.0


def test_motions_are_followed_back() -> None:
    osc = pc.impact_oscillator(STEEL, wall=1, side="above", damping="0.05")
    saddle = next(
        orbit
        for orbit in pc.find_orbits(osc, pc.cosine("0.9", amplitude="0.5"), 2, 2)
        if orbit.n_impacts and orbit.stability == "unstable"
    )

    curves = pc.manifolds(saddle, section="impact", kinds=("stable",), max_points=200)

    assert max(len(branch.points) for branch in curves.branches) > 10


def test_a_sweep_with_a_table_is_that_of_single_runs() -> None:
    osc = pc.impact_oscillator(STEEL, wall="0.2", side="above", damping="0.05")
    omegas = [2.3, 2.4, 2.5]

    data = pc.sweep(
        "peak_impact_velocity", osc, pc.cosine("2.5"), over={"forcing.omega": omegas},
        transient=20, periods=30,
    )  # fmt: skip

    for omega, peak in zip(omegas, data.peak_impact_velocity.values.ravel(), strict=True):
        run = pc.simulate(osc, pc.cosine(omega), periods=50)
        late = run.impacts.t >= 40 * math.pi / omega
        assert peak == np.abs(run.impacts.v_before[late]).max()


@pytest.mark.parametrize(
    ("speeds", "values", "message"),
    [
        ([1, 2], ["0.8"], "values = ('0.8',): 1 for 2 speeds; give one value at each"),
        ([], [], "values = (): 0 for 0 speeds"),
        ([1, 1], [1, 1], "speeds.1 = 1: not above the speed before it, 1"),
        ([-1, 1], [1, 1], "speeds.0 = -1: negative; it is the size of the velocity"),
        ([0, 1], [1, "1.1"], "values.1 = '1.1': above 1; an impact would create energy"),
        ([0, 1], [0, "0.1"], "values.0 = 0: not above 0; restitution=0 is a wall that stops"),
        ([0, math.nan], [1, 1], "speeds.1 = nan: not finite"),
        ([1, 2], [1, "0.3"], "the restitution falls so fast from speed 1 to 2 that a faster"),
        ([0, 1], [pc.parameter("r", "0.8"), 1], "values.0 = "),
        (["a"], [1], "speeds.0 = 'a': not a number"),
    ],
)
def test_a_table_that_creates_energy_or_is_none_is_refused(
    speeds: list[float], values: list[float], message: str
) -> None:
    with pytest.raises(pc.ParameterError) as caught:
        pc.restitution_table(speeds, values)

    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


STUDY = """
[oscillator]
damping = "0.05"
stops = [{type = "wall", at = 0, side = "below", restitution = {speeds = [0, "1.5"], values = ["0.9", "0.7"]}}]
[[forcing.harmonics]]
amplitude = 1
omega = "2.8"
[start]
x0 = 0
v0 = 1
[run]
periods = 10
"""


def test_a_study_holds_a_table_and_its_files_repeat_it(tmp_path: Path) -> None:
    study = parse_study(STUDY)

    wall = study.oscillator.stops[0]
    assert isinstance(wall, pc.Wall)
    assert wall.restitution == pc.restitution_table([0, "1.5"], ["0.9", "0.7"])
    assert parse_study(study.text()) == study
    for file in run_study(study, tmp_path).files:
        assert load_study(file) == study
    assert decoded(encoded(study.oscillator)) == study.oscillator
    assert pickle.loads(pickle.dumps(study.oscillator)) == study.oscillator


@pytest.mark.parametrize(
    ("old", "new", "fault"),
    [
        ('["0.9", "0.7"]', '["0.9"]', "restitution.values = "),
        ('["0.9", "0.7"]', '["0.9", 2]', "restitution.values.1 = 2: above 1; an impact would"),
        ('["0.9", "0.7"]', '["0.9", "0.1"]', "a faster impact leaves slower"),
        ("speeds = [0", "speed = [0", "restitution.speed: unknown key; did you mean"),
        ('speeds = [0, "1.5"]', "speeds = 3", "restitution.speeds = 3: not a list"),
    ],
)
def test_faults_of_a_table_in_a_file_name_its_place(old: str, new: str, fault: str) -> None:
    with pytest.raises(StudyError) as caught:
        parse_study(STUDY.replace(old, new))

    assert any(fault in line for line in str(caught.value).split("\n"))
