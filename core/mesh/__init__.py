"""The surface of a body at rest: built, repaired, ordered in rings, hit by rays."""
