"""Statements of the paper, section by section, each with the evidence it is held against."""
