"""Bakes and keyframed fingertips."""
