"""One periodic orbit as a value: its events, its stability, where it passes stops."""
