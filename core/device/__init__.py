"""Haptic devices: three fingertips that press a session and feel the measured law.

device: what Blender uses. workspace: from the device's space to a session's and back.
rendered_surface: the force on a fingertip. force_guard, passivity: what no force may exceed.
servo, servo_finger, received: what answers the device; servo_process, process, start, priority: the process that it
runs in. orders, mailbox: what it and Blender tell each other; notes: what it tells the artist.
wire, serial_line, udp_line, seal: the protocol and its lines. haply_line, web_socket: the Inverse3.
spec: the numbers of a device. limits: the numbers of this room.
"""
