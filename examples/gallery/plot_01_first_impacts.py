"""
From the first impact to the first bifurcation diagram
======================================================

A quarter of an hour with percuss: one motion, its periodic orbit, the family of that orbit, and a
bifurcation diagram. Each step is a few lines. Type them along, in a notebook or at a prompt; the
first call waits some seconds for the compiler, once after an installation.
"""

# %%
# An oscillator and a force
# -------------------------
#
# The equation is x'' + 2 a x' + k x = f(t) for a unit mass, with k = 1 where nothing else is said.
# A wall stands above the motion at x = 0.2; at an impact the velocity v turns into -0.8 v. Texts
# such as "2.8" are exact decimals; floats are taken as they are.

import matplotlib.pyplot as plt
import numpy as np

import percuss as pc
from percuss import plotting

osc = pc.impact_oscillator(restitution="0.8", wall="0.2", side="above", damping="0.05")
force = pc.cosine("3")

# %%
# One motion
# ----------
#
# Between impacts the solution is a formula, so there are no time steps and no tolerances: only from
# where, and for how long.

run = pc.simulate(osc, force, x0=0, v0="0.5", periods=60)
print(run)
print(run.impacts)

# %%
# The result is a function of time, and its events are columns: the instants of the impacts, the
# velocities before and after them, and where in the cycle of the force they fall.

x, v = run([1.0, 2.5])
print("x =", x, " v =", v)
print(run.impacts.t[:3])
print(run.impacts.v_before[:3])

# %%
# The picture that one wants first: displacement, phase portrait, impacts, spectrum.

plotting.plot_motion(run)

# %%
# Does it repeat?
# ---------------
#
# A longer run forgets its start. After that the impacts come in a pattern: one in every second
# period of the force.

settled = pc.simulate(osc, force, x0=0, v0="0.5", periods=600)
kind = pc.classify_impact_times(settled)
print(f"{kind.kind}: {kind.n_impacts} impact in {kind.n_periods} periods of the force")

# %%
# The periodic orbit itself, by Newton's method on the closed form of its flights: exact to
# rounding, with its multipliers. Both lie inside the unit circle, so that neighbours approach it.

orbit = pc.find_orbit(osc, force, n_impacts=kind.n_impacts, n_periods=kind.n_periods, guess=settled)
print(orbit)
print(f"between its impacts it turns {orbit.grazing_margin:.4f} off the wall")

figure, axes = plt.subplots(1, 2, figsize=(9, 4), layout="constrained")
plotting.plot_orbit(orbit, ax=axes[0])
plotting.plot_multipliers(orbit, ax=axes[1])

# %%
# Its family
# ----------
#
# Follow the orbit over the frequency of the force, both ways. Above, it ends at a fold: there it
# meets an unstable twin, and the two vanish. Below, it loses its stability at a period doubling.
# Further on the family grazes the wall once more, and what follows is formal: it would pass through
# the wall.

branch = pc.continue_orbit(orbit, over={"forcing.omega": (2.2, 4)})
for point in branch.special_points:
    print(f"{point.kind:>16} at omega = {point.value:.9f}, {point.status}")

figure, ax = plt.subplots(figsize=(8, 4.5), layout="constrained")
plotting.plot_branch(branch, ax=ax)

# %%
# A bifurcation diagram
# ---------------------
#
# Where the motion settles, for each of 800 frequencies: x once a period of the force. Green begins
# afresh from the same start at every frequency; blue goes on from where the frequency before ended.
#
# The two green lines on the right are our orbit, seen twice as it takes two periods of the force.
# They split at the period doubling of its family, and end just below the fold, where this start
# begins to lead elsewhere. Beside them the blue motion exists as well, which meets no wall.

# sphinx_gallery_thumbnail_number = 4
found = pc.bifurcation_diagram(
    osc,
    force,
    over={"forcing.omega": np.linspace(2.2, 4.0, 800)},
    follow=["forward"],
    starts=[(0, 0.5)],
)
print(found.sizes)

figure, ax = plt.subplots(figsize=(8, 5), layout="constrained")
plotting.plot_diagram(found, ax=ax)

# %%
# From here
# ---------
#
# - ``percuss serve`` shows all of this in the browser, with a slider for every parameter.
# - ``percuss new my_study.toml`` writes a commented study file to begin with, ``percuss run`` runs
#   it.
# - The pages by task (How to), the other scripts of this gallery, and the reference of every call.
