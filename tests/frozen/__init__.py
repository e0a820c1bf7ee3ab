"""Results that a change of the house must not change: `make frozen`."""
