"""Kernels of structures: several masses between stops, followed in their modes.

A module does for n modes what that of the same name one folder up does for one mass.
"""
