"""The paper's motions, and what they are compared with.

Averages, ensembles, the paper's own integrator, a smooth law.
"""
