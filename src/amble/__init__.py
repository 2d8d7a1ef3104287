"""amble."""
