"""Checked results of others, as data."""
