"""
A response chart
================

All periodic motions over the frequency of the force: how far they swing, which are stable, where
one turns into another.
"""

# %%
# A bilinear oscillator whose spring is nine times stiffer below 0. It resonates at 1.5, at twice
# that frequency, and at half of it.

import matplotlib.pyplot as plt

import percuss as pc
from percuss import plotting

osc = pc.bilinear_oscillator(stiffness_above=1, stiffness_below=9, damping="0.1")
print("resonant frequency:", pc.resonant_frequency(osc))
chart = pc.response_curve(
    osc, pc.cosine(1), over={"forcing.omega": (1, 4)}, max_impacts=2, max_periods=2, n_seeds=4
)
print(chart)
for family in chart.families:
    print((family.n_impacts, family.n_periods), "stable:", family.stable_ranges)

# %%
# Solid is stable, dashed unstable, (m, n) has m impacts in n periods of the force.

figure, ax = plt.subplots(figsize=(8, 4.8), layout="constrained")
plotting.plot_response(chart, "amplitude", ax, log_y=True)
