"""The section and the impact surface: maps, singularity set, manifolds."""
