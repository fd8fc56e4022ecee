"""The surface of a body at rest: built and measured (surface), repaired, its edges and rings, hit by a ray, and the
nearest points on it.
"""
