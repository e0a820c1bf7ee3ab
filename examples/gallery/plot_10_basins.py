"""
Basins of attraction
====================

To which motion does each start go?
"""

# %%
# Below a wall at 1.45789 the oscillator either hits it once a period or not at all. The border
# between their basins is the stable manifold of a saddle.

import matplotlib.pyplot as plt
import numpy as np

import percuss as pc
from percuss import plotting

osc = pc.impact_oscillator(restitution="0.7", wall="1.45789", side="above", damping="0.05")
force = pc.cosine("1.5")
basins = pc.basins(osc, force, x0=np.linspace(-6, 1.45, 150), v0=np.linspace(-6, 6, 150))
for i in range(basins.sizes["attractor"]):
    one = basins.isel(attractor=i)
    print(f"{one.name.item()}: {float(one.fraction):.1%} +- {float(one.fraction_error):.1%}")

saddle = next(
    orbit
    for orbit in pc.find_orbits(osc, force, max_impacts=1, max_periods=1)
    if orbit.stability == "unstable"
)

figure, ax = plt.subplots(figsize=(8, 5.5), layout="constrained")
plotting.plot_basins(basins, ax, manifolds=pc.manifolds(saddle))
