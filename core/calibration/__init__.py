"""From an instrument's file to a material, with numpy alone.

calibrate reads a file, or takes rows noted by hand, and gives constants as plain data. Each step stands on its own:

reading: reader (bytes to lines and cells), table (names, units, numbers), measurement (the columns, in SI), question.
press: strokes (order, signs, cycles, tears), press (selects one press), touch (first touch and tare).
fit: fit (least squares and intervals), doubts (what may be wrong), surface_constant (k).
pokes: a map of softness from a robot's table.
virtual_press presses a body as an instrument would, and writes the result as CSV.
"""
