"""Haptic devices: up to three fingertips that press a session and render the measured law.

device: what Blender uses. workspace: conversion between the device's space and the session's.
rendered_surface: the force on a fingertip. force_guard, passivity: the limits of every force.
servo, servo_finger, received: the answers to the device; servo_process, process, start, priority: the process that
runs the servo. orders, mailbox: the messages between it and Blender; notes: its messages to the artist.
wire, serial_line, udp_line, seal: the protocol and its lines. haply_line, web_socket: the Inverse3.
spec: the numbers that a device reports. limits: all other numbers of this package.
"""
