"""
A shallow graze and a chatter
=============================

The two cases on which event locators fail: a visit to the wall that is over before a time step
notices it, and infinitely many impacts in a finite time.
"""

# %%
# A graze
# -------
#
# x = (1 + 1e-4) sin t is the steady motion of x'' + 0.1 x' + x = A cos t with A = 0.1 (1 + 1e-4).
# It is beyond a wall at 1 for 0.03 units of time in each period. percuss passes over a stretch of a
# flight only when a bound shows that the stretch is free, so the impact is there.

import matplotlib.pyplot as plt
import numpy as np

import percuss as pc
from percuss import plotting

depth = 1e-4
osc = pc.impact_oscillator(restitution="0.8", wall=1, side="above", damping="0.05")
grazing = pc.simulate(osc, pc.cosine(1, amplitude=0.1 * (1 + depth)), v0=1 + depth, t_end=3)
print(f"percuss: {grazing.impacts.t[0]:.12f}")
print(f"exact:   {np.arcsin(1 / (1 + depth)):.12f}")

# %%
# Touches that rounding cannot decide are no impacts, and are listed:

touching = pc.simulate(osc, pc.cosine(1, amplitude="0.1"), v0=1, t_end=7)
print(touching.grazes)

# %%
# Chatter
# -------
#
# Below a wall at 0 small hops follow each other ever faster. The sum of the infinitely many is
# formed, with a bound of its error; then the mass rests on the wall, and leaves it when the force
# changes sign.

wall = pc.impact_oscillator(restitution="0.8", side="above")
chatter = pc.simulate(wall, pc.cosine("2.8"), x0=0, v0="-0.032", t0="-0.2", t_end=3)
print(chatter.contacts)
print(f"{int(chatter.contacts.n_impacts[0])} impacts listed, then their sum: "
      f"{chatter.contacts.start[0]:.15f} +- {chatter.contacts.error_bound[0]:.0e}")  # fmt: skip

# %%
# In the window on the right each hop is smaller than the one before; the last ones are too small to
# be seen, and all of them are in the table ``chatter.impacts``.

figure, (left, right) = plt.subplots(1, 2, figsize=(10, 4), layout="constrained")
half_pi = np.pi / 2
plotting.plot_displacement(grazing, left, window=(half_pi - 0.04, half_pi + 0.04))
left.set_title("a graze: 1e-4 too far")
plotting.plot_displacement(chatter, right, window=(-0.2, 0.7))
right.set_title("a chatter, a rest and a release")
