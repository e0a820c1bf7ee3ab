"""
The half harmonic
=================

A linear oscillator that is driven at its natural frequency grows in proportion to time. With a wall
at its equilibrium the resonant frequency is twice as high, so the natural frequency of the spring
is half of it. The motion still grows, but slowly.
"""

# %%
# From rest under sin t, elastic. ``growth`` fits the exponent of the envelope, with its error; over
# longer runs it tends to 1/2.

import matplotlib.pyplot as plt
import numpy as np

import percuss as pc
from percuss import plotting

osc = pc.impact_oscillator(restitution=1)
print("resonant frequency:", pc.resonant_frequency(osc))
run = pc.simulate(osc, pc.sine(1), t_end=40_000)
for t_end in (400, 4_000, 40_000):
    fit = pc.growth(pc.simulate(osc, pc.sine(1), t_end=t_end))
    print(f"up to t = {t_end}: exponent {fit.exponent:.3f} +- {fit.exponent_error:.3f}")

# %%
# The impacts come ever nearer to the eigenset k pi, and never reach it.

print(pc.classify_impact_times(run).kind)

figure, (left, right) = plt.subplots(1, 2, figsize=(10, 4), layout="constrained")
plotting.plot_displacement(run, left, window=(0, 120))
right.loglog(run.impacts.t, run.impacts.v_after, ".", ms=2, label="velocity after an impact")
t = np.array([10.0, 40_000.0])
last = run.impacts.v_after[-1] * np.sqrt(t / run.impacts.t[-1])
right.loglog(t, last, "k--", lw=1, label="square root of time")
right.set(xlabel="time $t$", ylabel="velocity after the impact")
right.legend(frameon=False)
