from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

import percuss as pc
from percuss import plotting

GAP, OMEGA = "oscillator.stops.0.at", "forcing.harmonics.0.omega"


def over_two() -> xr.Dataset:
    """Return fractions of two attractors over 2 x 3 points; the second is not everywhere."""
    second = np.array([[0.0, 0.25, 0.5], [0.0, 0.0, 0.125]])
    names = np.array([[["(1, 1)"] * 3] * 2, [["", "(0, 1)", "(0, 1)"], ["", "", "(2, 2)"]]])
    dims = ("attractor", GAP, OMEGA)
    return xr.Dataset(
        {
            "fraction": (dims, np.stack([1.0 - second, second])),
            "exists": (dims, names != ""),
            "name": (dims, names.astype(object)),
            "undecided": (dims[1:], np.zeros((2, 3))),
        },
        coords={GAP: [0.5, 0.7], OMEGA: [1.0, 1.5, 2.0]},
        attrs={"forcing": "Harmonic("},
    )


def test_a_chart_of_fractions_shows_one_attractor_and_leaves_out_where_it_is_not() -> None:
    ax = plotting.plot_fractions(over_two(), attractor=1)

    (image,) = ax.images
    shown = image.get_array()
    # Rows go upwards: the second parameter.
    assert shown.mask.tolist() == [[True, True], [False, True], [False, False]]
    assert shown[~shown.mask].tolist() == [0.25, 0.5, 0.125]
    assert image.get_clim() == (0.0, 1.0)
    assert (ax.get_xlabel(), ax.get_ylabel()) == (
        "place of stop 0",
        r"forcing frequency $\omega$",
    )
    assert [text.get_text() for text in ax.get_legend().get_texts()] == ["it does not exist"]
    bar = ax.figure.axes[-1]
    assert bar.get_ylabel() == "part of the starts that go to (0, 1), (2, 2)"


def test_the_attractor_to_which_most_go_is_the_one_shown() -> None:
    ax = plotting.plot_fractions(over_two())

    assert ax.figure.axes[-1].get_ylabel().endswith("(1, 1)")
    assert ax.get_legend() is None


@pytest.mark.parametrize(
    ("dimensions", "attractor", "message"),
    [(2, 2, "there are 2"), (2, -1, "there are 2"), (1, 0, "all of them are drawn")],
)
def test_an_attractor_that_cannot_be_shown_is_told(
    dimensions: int, attractor: int, message: str
) -> None:
    fractions = over_two()
    if dimensions == 1:
        fractions = fractions.isel({OMEGA: 0}, drop=True)

    with pytest.raises(pc.ParameterError, match=message):
        plotting.plot_fractions(fractions, attractor=attractor)


def test_over_one_parameter_the_parts_are_stacked() -> None:
    ax = plotting.plot_fractions(over_two().isel({GAP: 0}, drop=True))

    texts = [text.get_text() for text in ax.get_legend().get_texts()]
    assert texts == ["(1, 1)", "(0, 1)"]
    assert ax.get_ylim() == (0.0, 1.0)
