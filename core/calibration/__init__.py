"""From an instrument's file to a material, with numpy alone.

calibrate reads a file and fits the law of Eq. (1), and gives its result as plain data. Each step stands on its own:

read: reader (bytes to lines and cells), table (names, units, numbers; vocabulary), columns, measurement; question.
press: strokes (order, signs, cycles, tears), press, beginning (air or contact), touch (touch, tare, fit).
fit: segments (the law, two pieces), fit, doubts (what may be wrong), surface (k).
pokes: a map of softness from a robot's table.
virtual_press presses a body as an instrument would, export writes that as CSV.
"""
