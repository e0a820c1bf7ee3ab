"""The kinds of studies, one module each, named as its class."""
