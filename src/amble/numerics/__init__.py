"""Bezier curves, collocation schemes, small linear algebra."""
