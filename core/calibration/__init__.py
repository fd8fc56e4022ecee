"""From an instrument's file to a material, with numpy alone.

calibrate reads a file and fits the law of Eq. (1). identify finds the constants of the model with which a body follows
that law. Each of their steps stands on its own:

read: load (bytes to lines), dialect, table, vocabulary (headers, units), roles (columns), question, reader.
prepare: strokes, contact (first touch), prepare.
fit: segments (two pieces), distributions (t, F), fit, surface (k), calibrate, record (as plain data).
identify: indent (a virtual press), descent (by a flat tip), inversion (by a round one), identify, cache.
write: export (a press as CSV).
"""
