"""The surface of a body at rest: built and measured (surface), repaired, ordered in rings, hit by a ray, and how deep
a fingertip is below it (depth).
"""
