"""Haptic devices: three fingertips that press a session and feel the measured law.

device: what Blender uses. workspace: from the device's space to a session's and back.
surface: the force on a fingertip, from the surface under it. safety, passivity: what no force may exceed.
servo, servo_finger, received: what answers the device; servo_process, process, start, priority: the process that it
runs in. orders, mailbox: what it and Blender tell each other; notes: what it tells the artist.
wire, serial_line, udp_line, seal: the protocol and the lines. spec: the numbers of a device.
limits: the numbers of this room.
"""
