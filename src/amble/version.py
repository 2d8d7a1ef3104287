"""The version of the package, below everything that writes it."""

__version__ = "0.3.0"
