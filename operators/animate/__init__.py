"""Bakes, shape keys, and keyframed fingertips."""
