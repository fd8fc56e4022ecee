"""Bakes, shape keys, and fingertips that are keyframed."""
