"""The law of motion as all kernels read it: one array of one type for every case.

The line is cut at the stops into *regions*; inside one, the equation is linear,

    x'' + 2 a x' + K x = G + sum_j [ A_j cos(w_j t) + B_j sin(w_j t) ],

with the springs and dashpots of the stops in touch added to k and a. The bounds of a region are
walls, edges of soft stops, or at infinity.

A law is one C-contiguous float64 array, so that each kernel is compiled once, whatever the number
of stops and harmonics (docs/decisions/003-one-array-for-the-law.md). Row 0 holds what is common to
all; then comes one row for each harmonic; then, for each region upwards, a row of its own followed
by one row for each harmonic with the response of the region to it. A region is given by the number
of its row; the row of its response to harmonic j is ``region + 1 + j``.

A record, a force that is linear between knots, takes the last of the harmonics' rows. Behind the
regions come the knots of tables of restitution (`restitution`), and last those of the record
(`pieces`).
"""

from __future__ import annotations

from typing import TypeAlias

from percuss.arrays import Floats

Law: TypeAlias = Floats

# Columns of row 0. The period's entries are 0 without one.
N_HARMONICS, N_REGIONS = 0, 1
PERIOD, PERIOD_TURNS, PERIOD_TURNS_LOW = 2, 3, 4
# From here on: sum_j force_j w_j**m for m = 0, 1, ..., a bound of the force's m-th derivative.
FORCE_BOUND = 5
N_FORCE_BOUNDS = 14
# The mass: all else is per unit mass, and forces, impulses and energies are that times the mass.
MASS = 19
# The number of knots of the record, the row of the first; the force before it; and the time after
# which it begins again, as the sum of two, 0 where it does not.
N_KNOTS, FIRST_KNOT, OUTSIDE_FORCE, REPEAT, REPEAT_LOW = 20, 21, 22, 23, 24
FORCING_CONSTANT = 25

# Columns of a harmonic's row, the rows from FIRST_HARMONIC on.
FIRST_HARMONIC = 1
COSINE, SINE, OMEGA, TURNS, TURNS_LOW, AMPLITUDE = 0, 1, 2, 3, 4, 5

# Columns of a region's row.
LOWER, UPPER = 0, 1  # the positions of its two bounds
LOWER_KIND, UPPER_KIND = 2, 3
LOWER_RESTITUTION, UPPER_RESTITUTION = 4, 5
NUMBER = 6  # of the region, upwards from 0; its bounds have the numbers NUMBER and NUMBER + 1
STIFFNESS, DAMPING = 7, 8  # K and a
OVERDAMPED = 9  # 1 where a**2 > K, else 0
RATE = 10  # sqrt(abs(K - a**2)): a frequency, or half the difference of two real roots
HALF_TURNS, HALF_TURNS_LOW = 11, 12  # RATE / (4 pi): half the phase of the free motion, in turns
SLOW_ROOT, FAST_ROOT = 13, 14  # the larger and the smaller real root where overdamped
QUICKEST = 15  # the largest rate of the free motion
ORIGIN, ORIGIN_FORCE = 16, 17  # a point of the region and the constant force G - K x there
LOWER_FORCE, UPPER_FORCE = 18, 19  # the constant force at the bounds
STEP = 20  # length of one step of the search for events; 0 where the acceleration is constant
BOUND_OF_X, BOUND_OF_V = 21, 22  # see flight.derivative_bound
TWICE_PER_RATE, PER_STIFFNESS = 23, 24  # 2 / RATE and 1 / K, 0 where infinite
# 1 where there is one harmonic and nothing singular, and where moreover one wall is all there is.
SIMPLE, HARMONIC = 25, 26
LOWER_ENTRY, UPPER_ENTRY = 27, 28  # 1 where passing the edge from here enters a soft stop
GROWTH = 29  # the rate of the fastest growing part of the free motion; 0 where none grows
LOWER_TABLE, UPPER_TABLE = 30, 31  # where restitution is a table the row of its first knot, else 0
# (x, v) after 1, 2, ... STEPS_AHEAD steps, a column for each, from (x, v) before them and from a
# constant force; as many columns of a response have them from the force's two parts before them,
# and the turn of these.
STEPS_AHEAD = 8
X_OF_X, X_OF_V, V_OF_X, V_OF_V, X_OF_FORCE = 32, 40, 48, 56, 64
V_OF_FORCE = X_OF_V
# The largest sum of the magnitudes of the terms of a unit force's responses over these steps.
WALK_SIZE = 72

# Values of a bound's kind: at infinity, a wall, the edge of a soft stop.
NOTHING, WALL, EDGE = 0.0, 1.0, 2.0

# Columns of the row of a region's response to a harmonic.
GAIN_RE, GAIN_IM = 0, 1  # 1 / (K - w**2 + 2 i a w), of the steady motion; 0 where infinite
NEAR = 2  # 1 where i w lies so near to a characteristic root that the steady motion is useless
GAP_RE, GAP_IM = 3, 4  # i w minus that root
X_OF_COS, X_OF_SIN, V_OF_COS, V_OF_SIN, STEP_COS, STEP_SIN = 32, 40, 48, 56, 64, 72

COLUMNS = 80

# Columns of a knot of a table of restitution over the speed.
KNOT_SPEED, KNOT_RESTITUTION = 0, 1
KNOTS_LEFT = 2  # how many of the table follow

# Entries of a knot of a record: its instant as the sum of two; the force and its slope from there.
KNOT_T, KNOT_T_LOW, KNOT_FORCE, KNOT_SLOPE = 0, 1, 2, 3
KNOT_ENTRIES, KNOTS_A_ROW = 4, 16
# What stands for the frequency in the row of a record.
RECORD_OMEGA = -1.0

# Columns of the table of stops, which is no part of the law, per unit mass: its edge, stiffness and
# dashpot 2 a; the first and the last region in which it acts, none for a wall; the number of a
# wall's bound, -1 for a soft stop.
STOP_AT, STOP_STIFFNESS, STOP_DRAG, STOP_FIRST, STOP_LAST, STOP_BOUND = range(6)
STOP_COLUMNS = 6
