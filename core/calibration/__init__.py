"""From an instrument's file to a material, with numpy alone.

calibrate reads a file and fits the law of Eq. (1). Each of its steps stands on its own:

read: load (bytes to lines), dialect, table, vocabulary (headers, units), roles (columns), question, reader.
prepare: strokes, contact (first touch), prepare.
fit: segments (two pieces), distributions (t, F), fit, surface (k), calibrate, record (as plain data).
press: virtual_press (a body under a tip), export (a press as CSV).
"""
