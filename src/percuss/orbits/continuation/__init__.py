"""Numerical continuation: one corrector, one walk and one way to locate what lies on it."""
