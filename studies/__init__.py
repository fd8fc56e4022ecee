"""The laboratory, outside the zip: time-stepping methods that do not ship, scenes, what charts and tables are made of,
a test bench for haptic devices, and the commands of `python3 dev.py core`. It imports core, never the other way.
"""
