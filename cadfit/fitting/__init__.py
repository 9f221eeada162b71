"""From points to curves, and how far a curve is from its points."""
