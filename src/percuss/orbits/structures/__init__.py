"""Periodic orbits of structures: found by shooting, followed along parameters."""
