"""From an instrument's file to a material, with numpy alone.

calibrate reads a file and fits the law of Eq. (1); record is its result as plain data. Each step stands on its own:

read: reader (bytes to lines), dialect (cells, numbers), table, vocabulary and units, columns, question.
press: direction (order, signs), strokes (cycles, dwell), press, beginning (air or contact), touch (touch, tare, fit).
fit: segments (two pieces), parameters, fit, doubts (what may be wrong), surface (k).
pokes: a map of softness from a robot's table.
virtual_press presses a body as an instrument would, export writes that as CSV.
"""
