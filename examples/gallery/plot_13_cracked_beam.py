"""
The spectrum of a cracked beam
==============================

A crack that opens and closes makes a beam a bilinear oscillator. Driven at half its resonant
frequency it answers at that frequency itself, which a beam without a crack does not.
"""

# %%
# The stiffness falls by 5 % while the crack is open. The spectrum comes from the closed form of the
# motion: no sampling, no aliasing, lines down to rounding.

import matplotlib.pyplot as plt

import percuss as pc
from percuss import plotting

cracked = pc.bilinear_oscillator(stiffness_above="0.95", stiffness_below=1, damping="0.01")
sound = pc.Oscillator(damping="0.01")
force = pc.cosine(pc.resonant_frequency(cracked) / 2, amplitude="0.1")
lines = {
    name: pc.line_spectrum(pc.simulate(beam, force, periods=600), force.period, 8)
    for name, beam in (("cracked", cracked), ("sound", sound))
}
for name, found in lines.items():
    print(f"{name:>8}", [f"{a:.1e}" for a in found.amplitude.values])

figure, axes = plt.subplots(1, 2, figsize=(10, 4), layout="constrained")
for ax, (name, found) in zip(axes, lines.items(), strict=True):
    plotting.plot_spectrum(found, ax)
    ax.set(title=name, ylim=(5e-6, 0.5))
