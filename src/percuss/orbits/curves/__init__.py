"""Curves of special points in two parameters."""
