"""Ordered points: cleaning and parametrization."""
