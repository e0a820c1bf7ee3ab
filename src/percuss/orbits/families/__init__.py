"""Families of periodic orbits along a parameter: branches and their special points."""
