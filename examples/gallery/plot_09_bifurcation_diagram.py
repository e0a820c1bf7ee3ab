"""
A bifurcation diagram
=====================

Where the motion settles, over the frequency of the force; and how sensitive it is to its start.
"""

# %%
# x'' + x = cos(omega t) above a wall at 0, r = 0.8: the velocities after the impacts. The one
# impact a period splits in two at 2.6533 (Budd & Dux 1994, in closed form).

import matplotlib.pyplot as plt
import numpy as np

import percuss as pc
from percuss import plotting

osc = pc.impact_oscillator(restitution="0.8")
force = pc.cosine("2.6")
found = pc.bifurcation_diagram(
    osc,
    force,
    over={"forcing.omega": np.linspace(2.55, 3.0, 400)},
    section="impacts",
    transient=200,
    points=100,
)
print(found.sizes)

figure, ax = plt.subplots(figsize=(8, 5), layout="constrained")
plotting.plot_diagram(found, ax)

# %%
# The Lyapunov exponent, right through the impacts, tells chaos from long periods.

for omega in ("2.6", "2.8"):
    print(omega, pc.lyapunov_exponents(osc, pc.cosine(omega), start=(0, 1), periods=4000))
