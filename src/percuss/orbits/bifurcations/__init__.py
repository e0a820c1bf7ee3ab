"""Branches of orbits in one parameter, curves in two, and what is special on them."""
