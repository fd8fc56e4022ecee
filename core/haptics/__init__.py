"""Haptic devices: three fingertips that press a session and render the measured law.

device: what Blender uses. contact_rendering and contact_model: from a touch to a force 1000 times a second.
servo, servo_finger, servo_process, safety: the process that answers the device, with mailbox and messages between it
and Blender; servo_notes are its sentences.
wire, serial_link, poller, losses, watch: the protocol on the line. spec, kinematics, vectors: the numbers of a device.
firmware, motors, sensors: what runs on a device. emulator and emulated_*: a device to try, behind pseudo_terminal.
start, command, process, scheduling: how the processes are started, and their priority.
"""
