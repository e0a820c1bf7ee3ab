"""
Order and chaos over two parameters
===================================

The largest Lyapunov exponent of the motion from rest, over the frequency of the force and the gap.
"""

# %%
# Brown is chaos, purple order. Green is minus infinity: the motion sticks to the wall on its way
# and forgets where it came from.

import matplotlib.pyplot as plt
import numpy as np

import percuss as pc
from percuss import plotting

chart = pc.sweep(
    "largest_lyapunov_exponent",
    pc.impact_oscillator(restitution="0.8", wall=0, side="above", damping="0.05"),
    pc.cosine(1),
    over={
        "forcing.omega": np.linspace(1.5, 4.5, 60),
        "oscillator.stops.0.at": np.linspace(-0.2, 0.6, 60),
    },
    start=(-0.3, 0.0),
    transient=150,
    periods=128,
)
exponent = chart["largest_lyapunov_exponent"]
print(f"chaotic: {float((exponent > 0.01).mean()):.0%} of the chart")

figure, ax = plt.subplots(figsize=(8, 5), layout="constrained")
plotting.plot_chart(chart, "largest_lyapunov_exponent", ax)
