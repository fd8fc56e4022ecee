"""Haptic devices: what they say, where their fingertips are, what keeps a hand safe. Standard library only."""
