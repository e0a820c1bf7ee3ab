"""
A fold and a graze
==================

The impact oscillator of COCO's tutorial (Dankowicz & Schilder, Recipes for Continuation, SIAM 2013,
example 15.2), followed in the amplitude of its force.
"""

# %%
# The impacting orbit ends at a fold 3e-5 below A = 0.1, comes back unstable, and loses the velocity
# of its impact at A = 0.1, where the motion without impacts begins to touch the wall.

import matplotlib.pyplot as plt

import percuss as pc
from percuss import plotting

osc = pc.impact_oscillator(restitution="0.8", wall=1, side="above", damping="0.05")
orbit = pc.find_orbit(osc, pc.cosine(1))
branch = pc.continue_orbit(orbit, over={"forcing.amplitude": (1, "0.05")})
for point in branch.special_points:
    print(f"{point.kind:>16} at A = {point.value:.12f}, {point.status}")

# %%
# On the right the same next to the graze. Faint are the formal orbits: they solve the equations of
# an orbit and pass through the wall. percuss follows them, and says so.

figure, (left, right) = plt.subplots(1, 2, figsize=(10, 4.2), layout="constrained")
plotting.plot_branch(branch, left)
plotting.plot_branch(branch, right)
right.set(xlim=(0.09995, 0.10006), ylim=(-0.004, 0.014), title="next to the graze")
right.ticklabel_format(axis="x", useOffset=False)
right.locator_params(axis="x", nbins=4)
