"""From an instrument's file to a material: numpy only.

calibrate.py reads a file and fits the law, identify.py finds the constants of the model with which a body answers by
that law. Their steps, each of which stands on its own:

read: load (bytes, lines), dialect, table, vocabulary (headers, units), roles (columns), question, reader.
prepare: strokes, contact (first touch), prepare.
fit: segments (two pieces), distributions (t, F), fit, surface (k), calibrate, record (as plain data).
identify: indent (a virtual press), sweep, identify, cache.
write: export (a press as CSV).
"""
