"""Numbers in, numbers out: the compiled loops and the formulas they evaluate."""
