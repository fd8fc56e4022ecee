"""A test bench for haptic devices: an emulated one, with faults on demand, and a servo that keeps a log.

emulator: firmware, motors, sensors, linkage, tip, hand and line on one clock; numbers are its own.
pseudo_terminal, command: it as a process behind a port. faults, faulty_emulator: what goes wrong. round_trips: how a
device measures its link. processes, start, logged_servo: the processes of a study.
"""
