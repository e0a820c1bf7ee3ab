"""
Certain digits
==============

Chaos doubles each error again and again. In ball arithmetic every number carries a radius that is
proven, and the precision rises until the digits asked for are there.
"""

# %%
# Needs the extra ``percuss[certified]``. The parameters are taken exactly as they were written:
# "2.8" is 14/5. A run in doubles goes first; then each of its impacts is proven to exist, and to be
# the next.

import matplotlib.pyplot as plt
import numpy as np

import percuss as pc

osc = pc.impact_oscillator(restitution="0.8")
run = pc.simulate(osc, pc.cosine("2.8"), x0=0, v0=1, max_impacts=60)
proven = pc.certify(run, digits=12, start=pc.Start(0, 1))
print(proven)
print(proven.impacts.t[59].text(12))

# %%
# The doubles beside the truth: each digit lost is a step of the staircase. The dashed line is one
# unit in the last place.

true = np.array([float(ball) for ball in proven.impacts.t])
error = np.abs(run.impacts.t - true)

figure, ax = plt.subplots(figsize=(8, 4), layout="constrained")
ax.semilogy(np.arange(1, 61), np.maximum(error, 1e-17), ".-")
ax.semilogy(np.arange(1, 61), np.spacing(true), "k--", lw=1)
ax.set(xlabel="impact", ylabel="error of its time in doubles")

# %%
# An orbit is proven to exist, to be alone, and to be stable:

print(pc.certify(pc.find_orbit(osc, pc.cosine("2.5"))))
