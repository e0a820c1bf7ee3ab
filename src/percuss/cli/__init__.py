"""The command ``percuss``."""

from __future__ import annotations

from percuss.cli.app import app, main

__all__ = ["app", "main"]
