"""Figures of the paper and beyond it, one module a motion."""
