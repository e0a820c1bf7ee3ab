from __future__ import annotations

import math
import pickle
import re
from collections.abc import Callable
from fractions import Fraction
from typing import Any

import mpmath
import numpy as np
import pytest

import percuss as pc
from percuss.errors import ParameterError
from percuss.model import (
    Oscillator,
    SoftStop,
    StructureStart,
    Wall,
    acting_sets,
    check_start,
    get_parameter,
    loads_of,
    long_form,
    moved_fields,
    parameter_paths,
    replace_parameter,
    replace_parameters,
)
from percuss.model.acting_sets import StructureSystem
from percuss.model.expression import parameters_in

ONE = pc.Structure(mass=2, stiffness=8)
TWO = pc.Structure(mass=[1, 2], stiffness=[[3, -1], [-1, 1]])


def on_two(*stops: Wall | SoftStop) -> pc.Structure:
    return pc.Structure(mass=[1, 2], stiffness=[1, 1], stops=stops)


# Values.


def test_matrices_are_kept_as_they_were_given() -> None:
    structure = pc.Structure(
        mass=[["0.1", 0], [0, Fraction(1, 3)]], stiffness=np.array([[2.0, -1.0], [-1.0, 1.0]])
    )

    assert structure.mass == (("0.1", 0), (0, Fraction(1, 3)))
    assert structure.damping == ((0, 0), (0, 0))
    assert structure.mass_matrix.tolist() == [[0.1, 0.0], [0.0, 1 / 3]]
    assert structure.stiffness_matrix.tolist() == [[2.0, -1.0], [-1.0, 1.0]]


@pytest.mark.parametrize("mass", [[1, 2], (1, 2), np.array([1, 2]), [[1, 0], [0, 2]]])
def test_a_diagonal_stands_for_its_matrix(mass: Any) -> None:
    assert pc.Structure(mass, [[3, -1], [-1, 1]]) == TWO


def test_a_sparse_matrix_and_a_table_are_matrices() -> None:
    """A finite-element program gives one, a spreadsheet the other."""
    sparse = pytest.importorskip("scipy.sparse")
    pandas = pytest.importorskip("pandas")

    structure = pc.Structure(
        sparse.csr_array(np.diag([1, 2])), pandas.DataFrame([[3, -1], [-1, 1]])
    )

    assert structure == TWO


def test_numbers_make_a_structure_of_one_coordinate() -> None:
    assert ONE.n == 1
    assert pc.Structure([[2]], [[8]], [[0]]) == ONE


def test_equal_structures_are_equal_and_survive_a_pickle() -> None:
    structure = pc.chain([1, "0.5"], [1, 2, 0], stops=[Wall(1, "above", "0.7", on=(1, -1))])
    again = pickle.loads(pickle.dumps(structure))

    assert again == structure
    assert hash(again) == hash(structure)
    assert eval(structure.text(), {"Structure": pc.Structure, "Wall": Wall}) == structure
    assert structure != pc.chain([1, "0.5"], [1, 2, 0])
    named = pc.chain([1, "0.5"], 1, stops=[pc.Wall(1, "above", on="top")], points={"top": [0, 1]})
    assert named.direction(named.stops[0].on).tolist() == [0.0, 1.0]


@pytest.mark.parametrize(
    ("stops", "words"),
    [
        ((), "undamped; no stops"),
        ([Wall("0.5", "above", on=7)], "undamped; wall above 0.5 on 7"),
        ([SoftStop(1, "below", 2, on=(1, *[0] * 7))], "undamped; soft stop below 1 on a direction"),
        ([SoftStop(1, "above", 2, on=i) for i in range(8)], "undamped; 8 soft stops"),
        (
            [*[SoftStop(1, "above", 2, on=i) for i in range(3)], Wall(2, "above", on=0)],
            "undamped; 1 wall, 3 soft stops",
        ),
    ],
)
def test_many_masses_are_shown_in_a_line(stops: Any, words: str) -> None:
    masses = pc.chain([1] * 8, [1] * 9, stops=stops)

    assert repr(masses) == f"<Structure: 8 coordinates, {words}>"
    # All of it stands in the call.
    assert eval(masses.text(), vars(pc.model)) == masses


def test_the_line_of_a_structure_names_its_points_and_damping() -> None:
    beam = pc.cantilever(2, damping_ratio="0.1", points={"tip": 1})

    assert repr(beam) == "<Structure: 2 coordinates, damped; no stops; points tip>"


def test_arrays_of_a_structure_cannot_be_changed() -> None:
    with pytest.raises(ValueError, match="read-only"):
        TWO.mass_matrix[0, 0] = 3.0


def test_the_text_of_a_stop_of_an_oscillator_is_what_it_was() -> None:
    """Stores know a study by this text."""
    assert repr(Wall(0.0, "below")) == "Wall(at=0.0, side='below', restitution=1.0)"
    assert repr(SoftStop(0.0, "below", 2)) == (
        "SoftStop(at=0.0, side='below', stiffness=2, damping=0.0)"
    )


def test_coordinate_0_of_an_oscillator_needs_no_name() -> None:
    assert Oscillator(stops=(Wall(0, "below", on=0),)) == Oscillator(stops=(Wall(0, "below"),))
    for on in (1, (1.0,), "tip"):
        with pytest.raises(ParameterError, match=re.escape("one coordinate; a Structure has")):
            Oscillator(stops=(Wall(0, "below", on=on),))


# What stops and loads act on.


def test_a_direction_is_not_normalised() -> None:
    structure = on_two(
        Wall(1, "above", on=1),
        SoftStop(1, "above", 3, on=(2, -4)),
        Wall(2, "above", on=0),
    )

    assert structure.stop_directions.tolist() == [[0.0, 1.0], [2.0, -4.0], [1.0, 0.0]]
    assert structure.direction(("0.5", 0)).tolist() == [0.5, 0.0]
    assert Wall(1, "above", on=np.array([2, -4])).on == (2, -4)  # type: ignore[arg-type]


def test_one_coordinate_needs_no_name() -> None:
    wall = Wall(1, "above")

    assert pc.Structure(1, 1, stops=[wall]).stop_directions.tolist() == [[1.0]]


def test_points_of_modes_are_directions() -> None:
    beam = pc.Structure.from_modes(
        ["0.5", 3], [0, "0.1"], {"tip": [2, -1], "root": [0, "0.5"]}, [Wall(1, "above", on="tip")]
    )

    assert beam.stop_directions.tolist() == [[2.0, -1.0]]
    assert beam.mass == ((1, 0), (0, 1))
    assert beam.stiffness_matrix.tolist() == [[0.25, 0.0], [0.0, 9.0]]
    assert beam.damping_matrix.tolist() == [[0.0, 0.0], [0.0, 0.6]]
    loads = pc.Loads({"root": pc.cosine(2), 0: pc.cosine(3)})
    assert loads.directions(beam).tolist() == [[0.0, 0.5], [1.0, 0.0]]


def test_loads_keep_their_order_and_hash() -> None:
    record = pc.record([0, 1], [0, 2])
    loads = pc.Loads({1: pc.cosine(2), (1, -1): record})

    assert loads.forcings == (pc.cosine(2), record)
    assert loads == pickle.loads(pickle.dumps(loads))
    assert hash(loads) == hash(pc.Loads([(1, pc.cosine(2)), ((1, -1), record)]))
    assert loads.directions(TWO).tolist() == [[0.0, 1.0], [1.0, -1.0]]
    assert eval(repr(loads), vars(pc.model)) == loads


def test_a_force_per_unit_mass_is_multiplied_by_the_mass_matrix() -> None:
    """Base excitation of a structure is M c a(t), as m a(t) is for one mass."""
    structure = pc.Structure([[2, "0.5"], ["0.5", 3]], [1, 1])
    loads = pc.Loads({(1, 1): pc.base_excitation(1, 2), 0: pc.cosine(2)})

    assert loads.directions(structure).tolist() == [[2.5, 3.5], [1.0, 0.0]]


def test_a_plain_force_acts_on_one_coordinate() -> None:
    assert loads_of(ONE, pc.cosine(2)) == pc.Loads({0: pc.cosine(2)})
    assert loads_of(TWO, {1: pc.cosine(2)}) == pc.Loads({1: pc.cosine(2)})
    assert loads_of(TWO).forcings == ()


def test_loads_have_the_period_that_all_have_or_the_one_given() -> None:
    wave, same, other = pc.cosine(2), pc.square_wave(2), pc.cosine(3)

    assert pc.Loads({0: wave, 1: same}).period == pytest.approx(math.pi, rel=1e-15)
    assert pc.Loads({0: wave, 1: other}).period is None
    both = pc.Loads({0: wave, 1: other}, period="2*pi")
    assert both.period == pytest.approx(2 * math.pi, rel=1e-15)
    constant = pc.Forcing(constant=1)
    assert pc.Loads({0: constant}).period is None
    assert pc.Loads({0: constant, 1: wave}).exact_period == wave.exact_period


# Mechanisms.


def test_a_chain_has_its_springs_between_neighbours() -> None:
    """NLvib's example 03: masses 1, 1, springs 0, 1, 1, damping 0.03 K."""
    chain = pc.chain([1, 1], ["0", 1, 1], ["0", "0.03", "0.03"])

    assert chain.stiffness_matrix.tolist() == [[1.0, -1.0], [-1.0, 2.0]]
    np.testing.assert_allclose(chain.damping_matrix, 0.03 * chain.stiffness_matrix, rtol=1e-15)


def test_sums_of_springs_are_exact() -> None:
    assert pc.chain([1], ["0.1", "0.2"]).stiffness == ((Fraction(3, 10),),)


def test_an_impact_pair_has_walls_on_the_difference() -> None:
    pair = pc.impact_pair([1, 2], "0.5", "0.8", springs=[4, 0, 0])

    assert pair.stops == (
        Wall(-0.5, "below", "0.8", on=(-1, 1)),
        Wall("0.5", "above", "0.8", on=(-1, 1)),
    )
    assert pair.stiffness_matrix.tolist() == [[4.0, 0.0], [0.0, 0.0]]
    absorber = pc.vibro_impact_absorber(1, 4, 2, "0.5", "0.8", absorber_damping=3)
    assert absorber.stops == pair.stops
    assert absorber.stiffness_matrix.tolist() == pair.stiffness_matrix.tolist()
    assert absorber.damping_matrix.tolist() == [[3.0, -3.0], [-3.0, 3.0]]


def cantilever_shape(b: Any, part: Any) -> Any:
    """Return cosh - cos - s (sinh - sin) as it stands in tables, at high precision."""
    s = (mpmath.sinh(b) - mpmath.sin(b)) / (mpmath.cosh(b) + mpmath.cos(b))
    return (
        mpmath.cosh(b * part)
        - mpmath.cos(b * part)
        - s * (mpmath.sinh(b * part) - mpmath.sin(b * part))
    )


def test_modes_of_a_cantilever_have_all_digits() -> None:
    """cosh - sinh in doubles loses all of them at the twelfth mode."""
    parts = {"tip": "1", "three": "0.3", "near": "1/64", "far": "0.99"}
    beam = pc.cantilever(
        300, length="2.5", bending_stiffness=7, mass_per_length="0.3", points=parts
    )
    # cosh b is 1e409 at the last mode, and cancels twice.
    with mpmath.workdps(900):
        unit = mpmath.sqrt(mpmath.mpf("0.75"))
        square = mpmath.mpf(7) / mpmath.mpf("0.3") / mpmath.mpf("2.5") ** 4
        for k in (1, 2, 3, 5, 12, 40, 237, 300):
            b = mpmath.findroot(
                lambda z: mpmath.cos(z) + 1 / mpmath.cosh(z),
                (k - mpmath.mpf(1) / 2) * mpmath.pi + (mpmath.mpf("0.3") if k == 1 else 0),
            )
            got = beam.stiffness_matrix[k - 1, k - 1]
            assert abs(got / float(b**4 * square) - 1) < 3e-16
            for name, part in parts.items():
                place = mpmath.mpf(Fraction(part).numerator) / Fraction(part).denominator
                want = cantilever_shape(b, place) / unit
                assert abs(beam.direction(name)[k - 1] - want) < 1e-15


def test_modes_of_a_cantilever_are_orthonormal() -> None:
    """The integral of m phi_i phi_j is 1 for i = j and else 0."""
    nodes, weights = np.polynomial.legendre.leggauss(60)
    points = {f"p{i}": float(0.5 * (node + 1)) for i, node in enumerate(nodes)}
    beam = pc.cantilever(8, length=3, mass_per_length=2, points=points)
    shapes = np.array([beam.direction(name) for name in points])

    products = 6 * np.einsum("pi,pj,p->ij", shapes, shapes, 0.5 * weights)

    np.testing.assert_allclose(products, np.eye(8), atol=1e-13)


# Bad input, one sentence each.


BAD: list[tuple[Callable[[], object], str]] = [
    (lambda: pc.Structure([[1, 2], [2.5, 9]], [1, 1]),
     "mass.0.1 = 2: not mass.1.0 = 2.5; a mass is symmetric, as (M + M.T) / 2 is"),
    (lambda: pc.Structure([[1, 2], [2, 3]], [1, 1]),
     ("mass.1.1 = 3: the mass is not positive definite; -1 of this entry is left after elimination "
      "of the coordinates before it")),
    (lambda: pc.Structure([[1, 1], [1, 1]], [1, 1]),
     ("mass.1.1 = 1: the mass is not positive definite; 0 of this entry is left after elimination "
      "of the coordinates before it")),
    (lambda: pc.Structure([1, 0], [1, 1]), "mass.1.1 = 0: not positive"),
    (lambda: pc.Structure([-1, 1], [1, 1]), "mass.0.0 = -1: not positive"),
    (lambda: pc.Structure([1, 1], [1, 1, 1]),
     "stiffness = (3, 3): 3 x 3, but the mass is 2 x 2; all matrices have one size"),
    (lambda: pc.Structure([1, 1], [[1, 1]]),
     "stiffness = (1, 2): 1 rows, of which one has 2 entries; the matrix is not square"),
    (lambda: pc.Structure([1, 1], [[1, 1], [1]]),
     "stiffness = (2, 2): 2 rows, of which one has 1 entries; the matrix is not square"),
    (lambda: pc.Structure([1, 1], [1, [1, 1]]),
     "stiffness = (1, (1, 1)): neither rows of a matrix nor its diagonal"),
    (lambda: pc.Structure([1, 1], 4),
     "stiffness = 4: one number for 2 coordinates; give 2 for a diagonal, or the matrix"),
    (lambda: pc.Structure([], []), "mass = (): empty; a structure has coordinates"),
    (lambda: pc.Structure([1, math.nan], [1, 1]), "mass.1.1 = nan: not finite"),
    (lambda: pc.Structure([1, 1], [[1, "a"], [0, 1]]), "stiffness.0.1 = 'a': not a number"),
    (lambda: pc.Structure([1, 1], [1, 1], [0, 1e99]), "damping.1.1 = 1e+99: not between"),
    (lambda: pc.Structure([1e-60, 1], [1e60, 1]),
     "stiffness = 1e+60: beyond 1e+70 times the least mass 1e-60; choose other units"),
    (lambda: pc.Structure(1, 1, units="m"), "units = 'm': not a Units"),  # type: ignore[arg-type]
    (lambda: pc.Structure(1, 1, stops=[1]),  # type: ignore[list-item]
     "stops.0 = 1: neither a Wall nor a SoftStop"),
    (lambda: on_two(Wall(0, "below")),
     ("stops.0.on = None: not said on what it acts; the coordinates are 0 to 1; give one, or a "
      "direction")),
    (lambda: on_two(Wall(0, "below", on=2)),
     "stops.0.on = 2: no such coordinate; the coordinates are 0 to 1"),
    (lambda: on_two(Wall(0, "below", on=-1)),
     "stops.0.on = -1: no such coordinate; the coordinates are 0 to 1"),
    (lambda: on_two(Wall(0, "below", on=(0, 0.0))),
     "stops.0.on = (0, 0.0): a direction of zeros; what acts on it moves nothing"),
    (lambda: on_two(Wall(0, "below", on=(1,))),
     "stops.0.on = (1,): 1 number for 2 coordinates; a direction has one for each"),
    (lambda: on_two(Wall(0, "below", on=(1, math.inf))), "stops.0.on.1 = inf: not finite"),
    (lambda: on_two(Wall(0, "below", on=1.5)),  # type: ignore[arg-type]
     "stops.0.on = 1.5: neither a coordinate's index nor a direction's tuple nor a point's name"),
    (lambda: on_two(Wall(0, "below", on="tip")),
     ("stops.0.on = 'tip': no such point; the structure has no named points; give a coordinate or "
      "a direction")),
    (lambda: pc.cantilever(2, stops=[Wall(1, "above", on="top")]),
     "stops.0.on = 'top': no such point; did you mean tip?"),
    (lambda: pc.cantilever(2, stops=[Wall(1, "above", on="middle")]),
     "stops.0.on = 'middle': no such point; there are tip"),
    (lambda: on_two(Wall(0, "below", 1.5, on=0)),
     "restitution = 1.5: outside [0, 1]; above 1 an impact would create energy"),
    (lambda: on_two(*(SoftStop(i, "above", 1, on=0) for i in range(70))),
     "stops = 70: more than the 62 whose sets have a number each"),
    (lambda: on_two(Wall(1, "below", on=0), Wall("0.5", "above", on=0)),
     "stops.1.at = '0.5': not above the lower wall at x = 1; the walls leave no room"),
    (lambda: on_two(Wall(1, "below", on=(1, -1)), Wall(-1, "below", on=(-2, 2))),
     "stops.1.at = -1: not above the lower wall at y = 1; the walls leave no room"),
    (lambda: on_two(Wall(1, "above", on=(1, 2)), Wall(4, "above", on=(2, 4))),
     "stops.1.side = 'above': a second wall above; stops.0 at y = 1 is one, keep the inner"),
    (lambda: on_two(Wall(1, "above", on=(1, 2)), SoftStop(-4, "below", 3, on=(-2, -4))),
     "stops.1.at = -4: behind the wall above at y = 1, where it would never act"),
    (lambda: pc.Structure(1, 1, points=["tip"]),  # type: ignore[list-item]
     "points = ['tip']: not directions by their names"),
    (lambda: pc.Structure(1, 1, points={"tip": [0]}),
     "points.tip = (0,): a direction of zeros; what acts on it moves nothing"),
    (lambda: pc.Structure(1, 1, points=[("tip", [1]), ("tip", [2])]),
     "points.tip = (2,): the name of another point, too"),
    (lambda: pc.Structure.from_modes([1, 2], [0, 0, 0], {}),
     "damping_ratios = (0, 0, 0): 3 numbers, but 2 are needed, one for each of the frequencies"),
    (lambda: pc.Structure.from_modes([1, -2], 0, {}), "frequencies.1 = -2: negative"),
    (lambda: pc.Structure.from_modes([1, 2], 0, {"tip": [1]}),
     "points.tip = (1,): 1 number for 2 coordinates"),
    (lambda: pc.chain([1, 1], [1, 1]),
     ("springs = (1, 1): 2 numbers, but 3 are needed, one for each of the 3 gaps from ground to "
      "ground")),
    (lambda: pc.chain([1, 0], [1, 1, 1]), "masses.1 = 0: not positive"),
    (lambda: pc.impact_pair([1], 1), "masses = (1,): 1 masses; a pair has two"),
    (lambda: pc.impact_pair([1, 1], 0), "gap = 0: not positive; the walls leave no room"),
    (lambda: pc.cantilever(0), "n_modes = 0: not a whole number from 1 to 1000"),
    (lambda: pc.cantilever(2, points={"tip": "1.5"}),
     "points.tip = '1.5': above 1; it is a part of the length, from 0 to 1"),
    (lambda: pc.cantilever(2, points={"root": 0}), "points.root = 0: at the clamp"),
    (lambda: pc.Loads([pc.cosine(2)]),  # type: ignore[list-item]
     "phase=0.0),), constant=0.0)]: not forces by what they act on, {0: pc.cosine(2)}"),
    (lambda: pc.Loads(pc.cosine(2)),  # type: ignore[arg-type]
     "phase=0.0),), constant=0.0): not forces by what they act on, {0: pc.cosine(2)}"),
    (lambda: loads_of(TWO, pc.cosine(2)),
     "one force for 2 coordinates; give Loads({0: force})"),
    (lambda: loads_of(TWO, {2: pc.cosine(2)}),
     "loads.0 = 2: no such coordinate; the coordinates are 0 to 1"),
    (lambda: loads_of(pc.cantilever(2), {0: pc.cosine(2), "tap": pc.cosine(2)}),
     "loads.1 = 'tap': no such point; did you mean tip?"),
    (lambda: pc.Loads({3: pc.cosine(2)}).directions(TWO),
     "loads.0 = 3: no such coordinate"),
    (lambda: pc.Loads({0: 3}), "loads.0 = 3: not a Forcing"),  # type: ignore[arg-type]
    (lambda: pc.Loads({1.5: pc.cosine(2)}), "loads.0 = 1.5: neither a coordinate's index"),
    (lambda: pc.Loads({0: pc.cosine(2), 1: pc.cosine(3)}, period="pi"),
     "loads.period = 'pi': for loads.1: harmonic 0 of omega = 3 makes 1.5 turns"),
    (lambda: pc.Loads({0: pc.Forcing(constant=1)}, period=1),
     "loads.period = 1: given for constant loads"),
    (lambda: check_start(TWO, x0=[1]),
     "x0 = (1,): 1 number for 2 coordinates; give one for each"),
    (lambda: check_start(TWO, v0=1), "v0 = 1: not 2 numbers, one for each coordinate"),
    (lambda: check_start(TWO, v0=[0, math.nan]), "v0.1 = nan: not finite"),
    (lambda: check_start(on_two(Wall(1, "above", on=(1, -1))), x0=[2, "0.5"]),
     "x0 = (2, '0.5'): y = 1.5 is above the wall stops.0 at y = 1; start on its"),
    (lambda: StructureStart((0, 0), (1,)),
     "v0 = (1,): 1 velocities for 2 coordinates; give one for each"),
]  # fmt: skip


@pytest.mark.parametrize(("make", "message"), BAD, ids=[message[:40] for _, message in BAD])
def test_bad_input_is_told_in_one_sentence(make: Callable[[], object], message: str) -> None:
    with pytest.raises(ParameterError, match=re.escape(message)):
        make()


def test_more_sets_of_acting_stops_than_memory_are_told_in_one_sentence(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    structure = on_two(*(SoftStop(i + 1, "above", 1, on=0) for i in range(4)))
    system = StructureSystem(structure, pc.Loads())
    system.add(0)
    taken = sum(array[0].nbytes for array in system.sets[:16])
    monkeypatch.setattr(acting_sets, "MOST_BYTES", 2 * taken)
    system.add(1)

    with pytest.raises(ParameterError, match=r"stops = 4: the motion has met 3 sets of acting"):
        system.add(2)
    # What is there still serves.
    assert system.sets.keys.tolist() == [0, 1]


def test_stops_that_fit_are_taken() -> None:
    """Walls on one line but apart, on lines of their own, and soft stops before walls."""
    on_two(Wall(1, "above", on=(1, -1)), Wall("1.5", "above", on=(-1, 1)))
    on_two(Wall(1, "above", on=0), Wall(0, "below", on=1), Wall(-1, "below", on=(1, -1)))
    on_two(Wall(1, "above", on=(1, 2)), SoftStop(-1, "below", 3, on=(-2, -4)))


def test_a_start_at_a_wall_is_not_inside_it() -> None:
    """0.1 + 0.2 in doubles lies above 0.3; the numbers as written do not."""
    structure = on_two(Wall("0.3", "above", on=(1, 1)))

    start = check_start(structure, x0=["0.1", "0.2"], v0=np.array([1, 2]))

    assert start.x.tolist() == [0.1, 0.2]
    assert start.v.tolist() == [1.0, 2.0]


# Paths.


def test_entries_stops_loads_and_starts_have_paths() -> None:
    structure = on_two(Wall(1, "above", "0.7", on=0), SoftStop(0, "below", 9, 2, on=1))
    loads = pc.Loads({0: pc.cosine(2), (1, -1): pc.fourier(3, cos=[1, 2])})

    paths = parameter_paths(structure, loads, check_start(structure, x0=["0.5", 0]))

    assert [path for path in paths if path.startswith("structure.mass")] == [
        "structure.mass.0.0", "structure.mass.0.1", "structure.mass.1.1",
    ]  # fmt: skip
    assert sum(path.startswith("structure.stiffness") for path in paths) == 4
    assert [path for path in paths if "stops" in path] == [
        "structure.stops.0.at", "structure.stops.0.restitution", "structure.stops.1.at",
        "structure.stops.1.stiffness", "structure.stops.1.damping",
    ]  # fmt: skip
    assert [path for path in paths if path.startswith("loads")] == [
        "loads.0.constant", "loads.0.harmonics.0.amplitude", "loads.0.harmonics.0.omega",
        "loads.0.harmonics.0.phase", "loads.1.constant", "loads.1.omega", "loads.1.cos.0",
        "loads.1.sin.0", "loads.1.cos.1", "loads.1.sin.1",
    ]  # fmt: skip
    assert paths[-5:] == ("start.x0.0", "start.x0.1", "start.v0.0", "start.v0.1", "start.t0")


def test_a_path_leads_to_the_number_and_replaces_it() -> None:
    structure = on_two(Wall(1, "above", "0.7", on=0))
    loads = pc.Loads({0: pc.cosine(2), (1, -1): pc.cosine(3) + pc.record([0, 1], [0, 1])})
    start = check_start(structure, x0=["0.5", 0])

    new, new_loads, new_start = replace_parameters(structure, loads, start, {
        "structure.stops.0.at": 2, "structure.mass.1.0": "0.25", "structure.damping.0.1": 5,
        "loads.1.omega": "3.5", "loads.1.record.amplitude": 4, "start.v0.1": 7,
    })  # fmt: skip

    assert new.stops == (Wall(2, "above", "0.7", on=0),)
    assert new.mass == ((1, "0.25"), ("0.25", 2))
    assert new.damping == ((0, 5), (0, 0))
    assert new_loads.items[0] == loads.items[0]
    assert new_loads.forcings[1].harmonics[0] == pc.cosine("3.5").harmonics[0]
    assert get_parameter(new, new_loads, new_start, "loads.1.record.amplitude") == 4
    assert new_start == StructureStart(("0.5", 0), (0.0, 7), 0.0)
    assert hash(new) == hash(pc.Structure(new.mass, new.stiffness, new.damping, new.stops))


def test_short_forms_and_periods_are_those_of_each_load() -> None:
    loads = pc.Loads({0: pc.cosine(2), 1: pc.cosine(3)})

    assert long_form("loads.1.omega", TWO, loads) == "loads.1.harmonics.0.omega"
    assert get_parameter(TWO, loads, None, "loads.1.period") == pc.pi_times(2, 3)
    _, new, _ = replace_parameter(TWO, loads, None, "loads.1.period", "pi")
    assert new == pc.Loads({0: pc.cosine(2), 1: pc.cosine(2.0)})
    assert moved_fields(TWO, loads, None, "loads.0.period").fields.keys() == {
        "loads.0.harmonics.0.omega"
    }


def test_a_tied_parameter_moves_matrices_and_loads() -> None:
    k, w = pc.parameter("k", 3), pc.parameter("w", 2)
    structure = pc.chain([1, 1], [k, 2 * k, 0])
    loads = pc.Loads({0: pc.cosine(w), 1: pc.cosine(w, amplitude=w**2)})

    assert parameters_in(structure, loads) == {"k": 3, "w": 2}
    assert {"k", "w"} <= set(parameter_paths(structure, loads))
    new, new_loads, _ = replace_parameters(structure, loads, None, {"k": 5, "w": 7})
    assert new.stiffness_matrix.tolist() == [[15.0, -10.0], [-10.0, 10.0]]
    assert [load.components()[0].cos for load in new_loads.forcings] == [1.0, 49.0]
    assert moved_fields(structure, loads, None, "k").fields.keys() == {
        f"structure.stiffness.{i}.{j}" for i in range(2) for j in range(2)
    }


def test_a_replaced_number_is_checked_and_an_unknown_path_told() -> None:
    structure = on_two(Wall(1, "above", "0.7", on=0))

    with pytest.raises(ParameterError, match=re.escape("structure.mass.1.1 = -1: not positive")):
        replace_parameter(structure, None, None, "structure.mass.1.1", -1)
    with pytest.raises(ParameterError, match=re.escape("did you mean structure.stops.0.at or")):
        long_form("structure.stops.0.as", structure)
    with pytest.raises(ParameterError, match=re.escape("did you mean structure.stops.0.at?")):
        long_form("wall", structure)
    with pytest.raises(ParameterError, match=re.escape("the same parameter, named twice")):
        replace_parameters(
            structure, None, None, {"structure.mass.0.1": 0, "structure.mass.1.0": 0}
        )


def test_nothing_given_is_a_start_at_rest_at_zero() -> None:
    zeros = StructureStart((0.0, 0.0), (0.0, 0.0))

    assert check_start(TWO) == check_start(TWO, x0=0, v0=0.0) == zeros
    assert check_start(ONE, x0=0) == StructureStart((0,), (0.0,))
