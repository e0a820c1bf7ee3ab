"""
The singularity set of the impact map
=====================================

States on the wall whose next impact has no velocity. Across these curves the impact map jumps, and
on one side of them its derivative is infinite: they order the attractors and the chaos of an impact
oscillator (Budd & Dux 1994).
"""

# %%
# Every point is a motion followed back in time from its touch, in closed form. Colours tell whether
# the next impact, the one after it or the third is the one without velocity.

import matplotlib.pyplot as plt

import percuss as pc
from percuss import plotting

osc = pc.impact_oscillator(restitution="0.8")
force = pc.cosine("2.7")
found = pc.singularity_set(osc, force, n_iterates=3)
print(found)

figure, ax = plt.subplots(figsize=(8, 5), layout="constrained")
plotting.plot_singularity_set(found, ax)

# %%
# The manifolds of a saddle of the same map, here the orbit with one impact a period beyond its
# period doubling:

saddle = pc.find_orbit(osc, force)
print(saddle)
grown = pc.manifolds(saddle, section="impact", length=3)
print(grown)

figure, ax = plt.subplots(figsize=(8, 5), layout="constrained")
plotting.plot_manifolds(grown, ax)
