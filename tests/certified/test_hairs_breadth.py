"""Statements and runs next to what decides them, by 1e-6 to 1e-80, against decisions of mpmath."""

from __future__ import annotations

import random
from fractions import Fraction

import mpmath
import pytest

import percuss as pc
from percuss.certified import Ending
from percuss.certified.statements import keeps_eigenset, keeps_subset

WALL = pc.impact_oscillator()
DIGITS = 150
Parts = list[tuple[int, Fraction]]


def hair(rng: random.Random) -> Fraction:
    """Return a number from 1e-6 to 1e-80, of either sign, or zero."""
    return rng.choice((-1, 1, 1, -1, 0)) * Fraction(1, 10 ** rng.choice((6, 20, 40, 60, 80, 80)))


def mp(value: Fraction) -> mpmath.mpf:
    return mpmath.mpf(value.numerator) / value.denominator


def least_velocity(parts: Parts, k: int) -> mpmath.mpf:
    """Return the velocity at which flight k touches the wall half way, next to the ends or at them.

    From the wall at (-1)^k times the odd sines, x = V sin s + sum of A (sin n s - n sin s)/(1 -
    n^2).
    """

    def needed(s: mpmath.mpf) -> mpmath.mpf:
        total = mpmath.mpf(0)
        for n, a in parts:
            sign = -1 if k % 2 and n % 2 else 1
            total += sign * mp(a) / (1 - n * n) * (mpmath.sin(n * s) / mpmath.sin(s) - n)
        return -total

    with mpmath.workdps(30):
        grid = [mpmath.pi * i / 400 for i in range(1, 400)]
        values = [needed(s) for s in grid]
        best = max(range(len(grid)), key=values.__getitem__)
    ends = mpmath.mpf("1e-40"), mpmath.pi - mpmath.mpf("1e-40")
    found = [needed(end) for end in ends]
    if 0 < best < len(grid) - 1:
        turn = mpmath.findroot(lambda s: mpmath.diff(needed, s), (grid[best - 1], grid[best + 1]))
        found.append(needed(turn))
    return max(found)


def decided(parts: Parts, v0: Fraction, gain: Fraction, n: int | None) -> bool | None:
    """Return whether the impacts keep to the eigenset; None where 1e-35 could change it."""
    if n is None and gain < 0:
        return False
    limits = [least_velocity(parts, k) for k in (0, 1)]
    flights = (0, 1) if gain >= 0 else (0, 1) if n is None else tuple(range(n))
    margins = [mp(v0 + k * gain) - limits[k % 2] for k in flights[: n or 2]]
    least = min(margins)
    return None if abs(least) < mpmath.mpf("1e-35") else bool(least > 0)


def check_eigensets(seed: int, count: int) -> None:
    rng = random.Random(seed)
    for _ in range(count):
        odd = [(rng.choice((3, 5, 7)), Fraction(rng.randint(-9, 9), rng.randint(1, 9)))]
        b = Fraction(rng.randint(-5, 5), rng.randint(1, 7))
        wanted = hair(rng) if rng.random() < 0.7 else Fraction(rng.randint(-3, 3), 20)
        # 4 A/3 + 8 B/15 is the gain of A sin 2t + B sin 4t.
        parts: Parts = [*odd, (2, Fraction(3, 4) * wanted - 2 * b / 5), (4, b)]
        gain = sum((Fraction(2 * n, n * n - 1) * a for n, a in parts if n % 2 == 0), Fraction(0))
        assert gain == wanted
        n = rng.choice((None, None, None, 1, 2, 3, 7))
        with mpmath.workdps(DIGITS):
            limit = max(least_velocity(parts, k) for k in (0, 1))
            near = Fraction(int(mpmath.floor(limit * 10**100)), 10**100)
        v0 = near + hair(rng) if rng.random() < 0.5 else near + Fraction(rng.randint(-9, 9), 7)
        if v0 < 0:
            continue
        force = sum((pc.sine(m, a) for m, a in parts[1:]), pc.sine(*parts[0]))
        with mpmath.workdps(DIGITS):
            truth = decided(parts, v0, gain, n)
        verdict = keeps_eigenset(WALL, force, v0, n_impacts=n)
        assert verdict.holds in (None, truth) or truth is None, (parts, v0, gain, n, verdict)


def check_ends(seed: int, count: int) -> None:
    """Impacts of free motion are at k pi: which of them are listed up to a time beside one."""
    rng = random.Random(seed)
    for _ in range(count):
        k, offset = rng.randint(1, 6), hair(rng)
        run = pc.simulate(WALL, v0=1, t_end=pc.pi_times(k) + offset)
        proven = pc.certify(run, digits=rng.choice((5, 12, 40)))
        assert proven.complete
        at_end = proven.outcome is Ending.impact_at_t_end
        assert len(proven.impacts) == k if at_end or offset > 0 else len(proven.impacts) == k - 1
        assert not (offset == 0 and not at_end)
        assert all(t.contains(f"{i}*pi") for i, t in enumerate(proven.impacts.t, 1))


def check_rest(seed: int, count: int) -> None:
    """A mass at rest on the wall leaves it at once or not, by the sign of c + A cos(phase)."""
    rng = random.Random(seed)
    for _ in range(count):
        a, offset = Fraction(rng.randint(1, 9), 7), hair(rng)
        phase, cosine = rng.choice(((0, 1), ("pi/3", Fraction(1, 2)), ("pi", -1), ("pi/2", 0)))
        force = pc.cosine(1, a, phase, constant=offset - a * cosine)
        record = pc.certify(pc.simulate(pc.impact_oscillator("1/2"), force, t_end=1))
        leaves = offset > 0 or (offset == 0 and phase == "pi")
        if not record.complete:
            continue
        held = len(record.contacts) > 0 and record.contacts.start[0].contains(0)
        assert held is not leaves, (a, offset, phase, record)


def check_subsets(seed: int, count: int) -> None:
    rng = random.Random(seed)
    for _ in range(count):
        m = rng.choice((2, 4, 6, 8))
        with mpmath.workdps(DIGITS):
            # A later flight leaves with 2q - V, for these m the whole condition.
            limit = 4 * mpmath.sin(mpmath.pi / (m + 1)) / (m + 1)
            near = Fraction(int(mpmath.floor(limit * 10**120)), 10**120)
        offset = hair(rng)
        verdict = keeps_subset(m, near + offset)
        if offset > 0:
            assert verdict.holds is not True, (m, offset, verdict)
        if offset < 0:
            assert verdict.holds is not False or m > 4, (m, offset, verdict)


def turning_point(
    omega: Fraction, a: Fraction, x0: Fraction, v0: Fraction
) -> tuple[mpmath.mpf, mpmath.mpf] | None:
    """Return time and height of the first maximum of the motion under a cos(omega t), K = 1."""
    p = mp(a) / (1 - mp(omega) ** 2)

    def v(t: mpmath.mpf) -> mpmath.mpf:
        free = -(mp(x0) - p) * mpmath.sin(t) + mp(v0) * mpmath.cos(t)
        return free - p * mp(omega) * mpmath.sin(mp(omega) * t)

    with mpmath.workdps(15):
        grid = [mpmath.mpf(i) / 40 for i in range(400)]
        speeds = [v(t) for t in grid]
    # It rises clearly until then.
    first = next((i for i, speed in enumerate(speeds) if speed <= 0), None)
    if first is None or first < 4 or min(speeds[: first - 1]) < 0.02:
        return None
    t = mpmath.findroot(v, (grid[first - 1], grid[first]), solver="anderson", tol=1e-300)
    x = p * mpmath.cos(mp(omega) * t) + (mp(x0) - p) * mpmath.cos(t) + mp(v0) * mpmath.sin(t)
    return t, x


def check_touches(seed: int, count: int) -> None:
    """A wall or a soft stop is 1e-6 to 1e-80 above or below the first maximum, beside another wall."""
    rng = random.Random(seed)
    done = 0
    while done < count:
        omega, a = Fraction(rng.randint(2, 30), 7), Fraction(rng.randint(-9, 9), 7)
        x0, v0 = Fraction(rng.randint(-5, 5), 10), Fraction(rng.randint(1, 12), 8)
        offset = hair(rng)
        with mpmath.workdps(200):
            turn = None if omega == 1 else turning_point(omega, a, x0, v0)
            if turn is None or offset == 0:
                continue
            t, top = turn
            at = Fraction(int(mpmath.floor(top * 10**120)), 10**120) + offset
            end = Fraction(int(t * 10**6), 10**6) + Fraction(1, 50)
        stop = rng.choice((pc.Wall(at, "above", "0.7"), pc.SoftStop(at, "above", 9, "0.1")))
        # The second wall is met by none of these motions: they begin above it and rise.
        below = pc.Wall(x0 - rng.choice((1, Fraction(1, 10**20))), "below", "1/2")
        stops = (stop, below) if rng.random() < 0.6 else (stop,)
        run = pc.simulate(pc.Oscillator(1, 0, stops), pc.cosine(omega, a), x0=x0, v0=v0, t_end=end)
        proven = pc.certify(run, start=(x0, v0), t_end=end, digits=rng.choice((5, 12)))
        met = sum(table.stop.tolist().count(0) for table in (proven.impacts, proven.crossings))
        assert proven.complete, proven
        assert (met > 0) is (offset < 0), (omega, a, x0, v0, offset, stops, proven)
        done += 1


CHECKS = (check_eigensets, check_ends, check_rest, check_subsets, check_touches)


@pytest.mark.parametrize("check", CHECKS)
def test_nothing_is_claimed_that_150_digits_contradict(check) -> None:  # type: ignore[no-untyped-def]
    check(seed=7, count=6)


@pytest.mark.nightly
@pytest.mark.parametrize("seed", range(2, 12))
@pytest.mark.parametrize("check", CHECKS)
def test_nothing_is_claimed_that_150_digits_contradict_often(check, seed: int) -> None:  # type: ignore[no-untyped-def]
    check(seed=seed, count=20)


@pytest.mark.nightly
@pytest.mark.parametrize("seed", range(20, 30))
def test_of_2000_touches_none_is_told_wrongly(seed: int) -> None:
    check_touches(seed, 200)
