"""From an instrument's file to a material: numpy only. `calibrate.py` is the way in; each step stands on its own.

read      load (bytes, lines), dialect, table, words (headers, units), roles (columns), question -> reader
prepare   strokes, contact (first touch), prepare
fit       segments (two pieces), distributions (t, F), fit, surface (k) -> calibrate
identify  indent (a virtual press), sweep, identify, cache, verdict, specimen
tell      report, plot, export, reconstruct, command
"""
