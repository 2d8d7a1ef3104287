"""Allocation laws, one a file."""

from amble.control.allocation.law import AllocationLaw, Redundancy

__all__ = ["AllocationLaw", "Redundancy"]
