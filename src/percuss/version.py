"""The version of percuss, for every layer."""

__version__ = "0.1.0"
