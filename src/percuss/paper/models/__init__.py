"""What the paper's motions are compared with: averages, ensembles, the paper's own integrator, a smooth law."""
