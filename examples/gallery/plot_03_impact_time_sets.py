"""
Impact times: the eigenset and its subsets
==========================================

Without a force an elastic impact oscillator returns to its wall after half a natural period,
whatever its speed: the times k pi are its eigenset. Dyskin, Pasternak & Pelinovsky (J. Sound Vib.
331, 2012) ask which forces leave these times alone.
"""

# %%
# The third harmonic, above and below the critical velocity
# ----------------------------------------------------------
#
# Under sin 3t the eigenset stays if the mass starts with at least V = 1/2 (their eq. 24, fig. 6).
# Below it the mass meets the wall six times in 4 pi instead of four, so that the staircase goes
# down.

import matplotlib.pyplot as plt
import numpy as np

import percuss as pc
from percuss import plotting

osc = pc.impact_oscillator(restitution=1)
above = pc.simulate(osc, pc.sine(3), v0="0.51", t_end="100*pi")
below = pc.simulate(osc, pc.sine(3), v0="0.45", t_end="100*pi")
print("critical velocity:", pc.harmonic_critical_velocity(3))
print("V0 = 0.51:", pc.classify_impact_times(above).kind)
kind = pc.classify_impact_times(below)
print("V0 = 0.45:", kind.kind, "with", kind.n_impacts, "impacts in", kind.n_periods, "periods")

figure, axes = plt.subplots(2, 2, figsize=(10, 6), layout="constrained")
for row, run, name in zip(axes, (above, below), ("V0 = 0.51", "V0 = 0.45"), strict=True):
    plotting.plot_displacement(run, row[0], window=(0, 4 * np.pi))
    plotting.plot_staircase(run, row[1])
    row[0].set_title(name)
    row[1].set(title="impact times less the eigenset's", xlim=(0, 31))

# %%
# Subsets of the eigenset
# -----------------------
#
# A force of frequency 2/(m+1) makes motions that meet the wall after m pi and pi in turn, up to a
# critical velocity of their own (their section 3; the coefficient of eq. 12 corrected). For m = 3:

force = pc.subset_forcing(3)
print(force)
print("up to V0 =", pc.subset_critical_velocity(3), "= 1 + 3 sqrt(2)/4")

run = pc.simulate(osc, force, v0=1, t_end="16*pi")
kind = pc.classify_impact_times(run)
print(kind.kind, run.impacts.t[:4] / np.pi)

figure, ax = plt.subplots(figsize=(8, 3.2), layout="constrained")
plotting.plot_displacement(run, ax)
