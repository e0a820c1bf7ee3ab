"""A study and its text are the same thing."""

from __future__ import annotations

from decimal import Decimal
from fractions import Fraction
from typing import Any

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

import percuss as pc
from percuss.errors import ParameterError
from percuss.model.exact import Exact, as_fraction
from percuss.studies import Draw, Limits, Motion, Save, Study, parse_study

floats = st.floats(-1e6, 1e6).filter(lambda x: x == 0.0 or abs(x) > 1e-60)
# What a study file holds is given back as it was; a Fraction or Decimal comes back as a text.
in_files = st.one_of(
    st.integers(-1000, 1000),
    floats,
    st.decimals(-1000, 1000, allow_nan=False, places=4).map(str),
    st.fractions(-9, 9, max_denominator=97).map(lambda f: f"{f.numerator}/{f.denominator}"),
)
numbers: st.SearchStrategy[Exact] = st.one_of(
    in_files,
    st.fractions(-9, 9, max_denominator=97),
    st.decimals(-1000, 1000, allow_nan=False, places=4),
)
phases = st.one_of(
    numbers,
    st.builds(pc.pi_times, st.integers(-9, 9), st.integers(1, 9)),
    st.builds(lambda p, plus: pc.pi_times(p, 2) + plus, st.integers(1, 9), numbers),
    st.sampled_from(["pi", "-pi/2", "3*pi/4"]),
)


def positive(values: st.SearchStrategy[Exact]) -> st.SearchStrategy[Exact]:
    return values.filter(lambda value: as_fraction(value) > 0)


def studies(values: st.SearchStrategy[Exact], angles: Any) -> st.SearchStrategy[Study]:
    """Return studies that the model accepts.

    Each strategy is made once: Hypothesis would check each anew for each study.
    """
    sizes = positive(values)
    stops = st.lists(
        st.one_of(
            st.builds(pc.SoftStop, values, st.sampled_from(["above", "below"]), values, sizes),
            st.builds(pc.Wall, values, st.sampled_from(["above", "below"]), st.just("0.25")),
        ),
        max_size=3,
    )
    harmonics = st.lists(st.builds(pc.Harmonic, values, sizes, angles), max_size=3)
    forcings = (
        st.none()
        | st.builds(pc.Forcing, harmonics, values)
        | st.builds(pc.fourier, sizes, st.lists(values, min_size=1, max_size=3),
                    st.lists(values, max_size=2), values)
    )  # fmt: skip
    limits = st.sampled_from([Limits(t_end=10), Limits("10*pi"), Limits(None, None, 5)])
    windows = st.none() | st.just((0, "pi"))
    titles = st.text(st.characters(exclude_categories=["Cs"]), max_size=20)
    samples, switches = st.integers(2, 99), st.booleans()

    @st.composite
    def accepted(draw: st.DrawFn) -> Study:
        try:
            oscillator = pc.Oscillator(draw(values), draw(sizes), tuple(draw(stops)))
        except ParameterError:
            assume(False)
        forcing = draw(forcings)
        start = pc.Start(draw(values), draw(values), 0)
        window = draw(windows)
        study = Study(
            oscillator,
            forcing,
            Motion(start, draw(limits)),
            title=draw(titles),
            save=Save(csv=draw(switches), samples=draw(samples)),
            draw=Draw(png=draw(switches), window=window, length_unit="mm"),
        )
        walls = [stop for stop in oscillator.stops if isinstance(stop, pc.Wall)]
        sign = {"below": 1, "above": -1}
        assume(all(sign[w.side] * (as_fraction(start.x0) - as_fraction(w.at)) >= 0 for w in walls))
        return study

    return accepted()


@given(studies(in_files, st.sampled_from([0, "0.5", "-pi/2"])))
def test_a_study_is_read_back_equal_from_its_text(study: Study) -> None:
    again = parse_study(study.text())

    assert again == study
    assert again.text() == study.text()


@given(studies(numbers, phases))
def test_no_number_loses_a_digit_in_the_text(study: Study) -> None:
    again = parse_study(study.text())

    assert again.text() == study.text()
    if study.forcing is not None and again.forcing is not None:
        assert again.forcing.components() == study.forcing.components()
        assert again.forcing.frequency == study.forcing.frequency
    pairs = zip(again.oscillator.stops, study.oscillator.stops, strict=True)
    assert all(as_fraction(a.at) == as_fraction(b.at) for a, b in pairs)


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (Fraction(1, 3), '"1/3"'),
        (Decimal("2.80"), '"2.80"'),
        (0.1, "0.1"),
        (1e300, "1e+300"),
        ("0.10", '"0.10"'),
        (7, "7"),
    ],
)
def test_numbers_are_written_as_they_were_given(value: Exact, text: str) -> None:
    study = Study(pc.impact_oscillator(), None, Motion(pc.Start(0, value), Limits(t_end=1)))

    assert f"\nv0 = {text}\n" in study.text()
