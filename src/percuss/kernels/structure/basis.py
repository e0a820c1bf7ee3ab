"""The modes of a structure under one set of acting stops, as all kernels of structures read them.

A *set* says which soft stops press and which walls the structure sticks to. Under one set the
equations are linear and fall apart into modes, each the equation of one mass,

    u' = w + beta . f,     w' = -k u - 2 a w + gamma . f,

under the loads f. With proportional damping u is a modal coordinate and beta vanishes; a pair of
complex modes is brought to the same form. So each mode stands in a `Law` as a region does, and the
closed forms of `flight` hold for it in every linear regime (docs/theory/structures.md).

A *guard*, as it is called for hybrid systems, is a function whose fall to zero ends a flight: the
clearance to a stop that is not in touch, how far a soft stop is pressed in, or the force by which a
wall holds. Each is linear in the modes and the loads.
All arrays have a first axis over the sets that the motion has met so far.
"""

from __future__ import annotations

from typing import NamedTuple

from percuss.arrays import Floats, Integers
from percuss.kernels.compile import formula
from percuss.kernels.law_columns import FIRST_HARMONIC, LOWER_KIND, N_HARMONICS, NUMBER, WALL

# Columns of a mode: k, 2 a, the factor of u in the norm that bounds its motion, constant parts of
# the input into w' and into u', and the norm of the second derivative of the harmonics' input.
SPRING, DRAG, ROOT, FORCE, RATE, SURGE = range(6)
MODE_COLUMNS = 6
# Entries of the input of a harmonic into a mode: into w' and u', of its cosine and its sine.
FORCE_COS, FORCE_SIN, RATE_COS, RATE_SIN = range(4)
DRIVE_ENTRIES = 4
# What a walk takes of a mode, a row each, so that loops over modes become vector instructions: the
# first columns of a mode, up to ROOT, and then the input of each harmonic.
WALK_ROWS = 3
# What a guard takes of a mode: of u, of w; of the norm of its second derivative, for a bound of
# the fourth derivative of the guard.
OF_U, OF_W, OF_NORM = range(3)
GUARD_ENTRIES = 3
# Columns of a guard: its constant; the bound of the harmonics' own part in its fourth derivative;
# the sum of OF_NORM times SURGE; whether loads enter it directly; whether it is watched at all; and
# of a clearance, less the change of its acceleration by a unit change of its own velocity.
CONSTANT, TWIST, SURGES, IS_FED, IS_ON, SELF_DRAG = range(6)
LEVEL_COLUMNS = 6
# The map of a mode over a step: S, D and E of `flight`, u from u, w from u and w from w; then for
# each harmonic u and w from its two phasors.
STEP_S, STEP_D, STEP_E, U_OF_U, W_OF_U, W_OF_W = range(6)
STEP_ENTRIES = 6
STEP_HARMONIC = 4
# Columns of a stop: whether it is a wall.
IS_WALL = 0
STOP_COLUMNS = 1
# Columns of a set: the length of its shortest step and the number of its steps; the largest rate;
# the rate of the fastest growing norm; whether loads enter the first equations of pairs.
STEP_LENGTH, N_LEVELS, QUICKEST, GROWTH, HAS_RATES = range(5)
SET_COLUMNS = 5


class Sets(NamedTuple):
    """The sets that are known, stacked.

    With b sets, n modes, n_x coordinates, m harmonics, r records, s stops and l levels of steps:

    - ``law`` (b, rows, COLUMNS): the modes as regions;
    - ``modes`` (b, n, MODE_COLUMNS), ``drive`` (b, n, m, 4), and ``walk``
      (b, WALK_ROWS + 4 m, n), what a walk takes of these;
    - ``record_drive`` (b, n, r, 2): input of each record into w' and u';
    - ``guard`` (b, s, n, 3), ``levels`` (b, s, LEVEL_COLUMNS), ``feed`` (b, s, m, 2) and
      ``record_feed`` (b, s, r): what a guard takes of the modes, of constants, and of the loads
      directly;
    - ``steps`` (b, l, STEP_ENTRIES + 4 m, n), ``turns`` (b, l, m, 2): the maps over steps of
      doubling lengths;
    - ``shape`` (b, n, 2, n_x): displacements of u and w; ``offset`` (b, n_x); ``inverse``
      (b, 2 n_x, 2, n);
    - ``kick`` (b, s, n, 2): the jump of the modes that changes the velocity of a stop by 1;
    - ``of_set`` (b, SET_COLUMNS); ``keys`` (b,): bits of the stops that act;
    - ``stops`` (s, STOP_COLUMNS); ``walls`` (s, rows, COLUMNS): laws that hold one wall each, for
      its restitution;
    - ``normals``, ``impulses`` (s, n_x): the gradient of the clearance to a stop, and the change of
      the velocities by an impulse that changes that of the clearance by 1;
    - ``records`` (r, rows, COLUMNS): laws that hold one record each.
    """

    law: Floats
    modes: Floats
    drive: Floats
    walk: Floats
    record_drive: Floats
    guard: Floats
    levels: Floats
    feed: Floats
    record_feed: Floats
    steps: Floats
    turns: Floats
    shape: Floats
    offset: Floats
    inverse: Floats
    kick: Floats
    of_set: Floats
    keys: Integers
    stops: Floats
    walls: Floats
    normals: Floats
    impulses: Floats
    records: Floats


class Basis(NamedTuple):
    """One of the `Sets`: the same arrays without the first axis."""

    law: Floats
    modes: Floats
    drive: Floats
    walk: Floats
    record_drive: Floats
    guard: Floats
    levels: Floats
    feed: Floats
    record_feed: Floats
    steps: Floats
    turns: Floats
    of_set: Floats


@formula
def basis_of(sets: Sets, b: int) -> Basis:
    """Return one of the sets."""
    return basis_with(sets, b, sets.guard[b], sets.levels[b], sets.feed[b], sets.record_feed[b])


@formula
def basis_with(
    sets: Sets, b: int, guard: Floats, levels: Floats, feed: Floats, record_feed: Floats
) -> Basis:
    """Return one of the sets with other guards."""
    return Basis(
        sets.law[b],
        sets.modes[b],
        sets.drive[b],
        sets.walk[b],
        sets.record_drive[b],
        guard,
        levels,
        feed,
        record_feed,
        sets.steps[b],
        sets.turns[b],
        sets.of_set[b],
    )


@formula
def find(sets: Sets, key: int) -> int:
    """Return the index of the set with these bits, -1 where it has not been made yet."""
    for b in range(sets.keys.shape[0]):
        if sets.keys[b] == key:
            return b
    return -1


@formula
def row_of(basis: Basis, j: int) -> int:
    """Return the row of a mode in its law."""
    m = basis.turns.shape[1]
    return FIRST_HARMONIC + m + j * (1 + m)


@formula
def wall_of(sets: Sets, i: int) -> tuple[int, int]:
    """Return the region and the number of the one wall in the law of a stop."""
    law = sets.walls[i]
    region = FIRST_HARMONIC + int(law[0, N_HARMONICS])
    number = int(law[region, NUMBER])
    return region, number if law[region, LOWER_KIND] == WALL else number + 1
