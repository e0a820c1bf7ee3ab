"""Finding periodic orbits: closed forms, runs, seeded search."""
