"""
All orbits of an oscillator, stable and unstable
================================================

A run shows the motions that attract. A search shows the others too, with their multipliers and the
clearance that is left to a graze.
"""

# %%
# x'' + 0.1 x' + x = cos 1.5 t below a wall at 1.45789, r = 0.7: Which periodic motions are there?

import matplotlib.pyplot as plt

import percuss as pc
from percuss import plotting

osc = pc.impact_oscillator(restitution="0.7", wall="1.45789", side="above", damping="0.05")
force = pc.cosine("1.5")
orbits = pc.find_orbits(osc, force, max_impacts=2, max_periods=2)
for orbit in orbits:
    print(orbit)
    print(f"    multipliers {orbit.multipliers.round(4)}, clearance {orbit.grazing_margin:.4f}")

# %%
# Two are seen in experiments, one with an impact a period and one without any. The saddle between
# them is seen in none, but its manifold is the border of their basins. In the plane of the
# multipliers the stable ones lie inside the unit circle. An (m, n) orbit has m impacts in n periods
# of the force.

figure, axes = plt.subplots(2, 3, figsize=(12, 8), layout="constrained")
for above, below, orbit in zip(*axes, orbits, strict=True):
    plotting.plot_orbit(orbit, above)
    above.set_title(f"({orbit.n_impacts}, {orbit.n_periods}) orbit, {orbit.stability}")
    plotting.plot_multipliers(orbit, below)
    below.set(xlim=(-2.6, 2.6), ylim=(-2.6, 2.6))
