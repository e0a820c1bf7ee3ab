"""
Curves in two parameters
========================

Each special point of a family becomes a curve when a second parameter is set free. Where curves
touch are points of codimension two.
"""

# %%
# COCO's impact oscillator again: the fold, the graze and the period doubling of its family, now
# over the frequency and the amplitude of the force.

import matplotlib.pyplot as plt

import percuss as pc
from percuss import plotting

osc = pc.impact_oscillator(restitution="0.8", wall=1, side="above", damping="0.05")
orbit = pc.find_orbit(osc, pc.cosine(1))
branch = pc.continue_orbit(orbit, over={"forcing.amplitude": (1, "0.05")})
plane = {"forcing.omega": ("0.6", "1.4"), "forcing.amplitude": ("0.01", "1")}
curves = [pc.continue_curve(point, over=plane) for point in branch.special_points]
for curve in curves:
    print(f"{curve.kind}: {len(curve)} orbits")
    for point in curve.special_points:
        print("   ", point.kind, "at", point.values)

# %%
# The grazing curve is known: A = sqrt((1 - w^2)^2 + (0.1 w)^2).

graze = next(curve for curve in curves if curve.kind == "grazing")
omega, amplitude = graze.values.T
print(f"off by at most {abs(amplitude - ((1 - omega**2) ** 2 + 0.01 * omega**2) ** 0.5).max():.0e}")

figure, ax = plt.subplots(figsize=(8, 5), layout="constrained")
plotting.plot_curves(curves, ax)
