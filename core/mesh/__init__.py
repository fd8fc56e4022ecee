"""The surface of a body at rest: construction (surface), repair, edges, one-rings (rings), and rays that hit it."""
