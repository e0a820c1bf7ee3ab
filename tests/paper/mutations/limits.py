"""Perturbed records on the limits: next to a resonance, smoothed, and rigid."""

from __future__ import annotations

from tests.paper.perturbed import Mutation, perturbed

from percuss.paper.claims.smoothed import RATE

MUTATIONS: list[Mutation] = [
    perturbed("fig2-intervals", "10 percent off the resonance", detuning=1.1),
    perturbed("commensurate-off-resonance", "another start than the periodic one", faster=0.1),
    perturbed("smoothed-converges", "first order", order=1.0),
    perturbed("smoothed-converges", "half the rate", rate=RATE / 2),
    perturbed("smoothed-grazing", "the order 2", power=2.0),
    perturbed("smoothed-in-time", "ln(1/rho)/lambda", factor=1.0),
    perturbed("smoothed-and-stiff", "k-^(-1/2)", power=-0.5),
    perturbed("bilinear-limit", "contacts of 3/sqrt(k-)", contact=3.0),
    perturbed("bilinear-limit-grazing", "k-^(-1/2)", power=-0.5),
    perturbed("bilinear-saturation", "3 for 4", factor=3.0),
    perturbed("bilinear-saturation-half", "0.4 for 1/2", most=0.4),
]
UNMOVED: dict[str, str] = {}
