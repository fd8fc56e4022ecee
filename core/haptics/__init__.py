"""Haptic devices: protocol, kinematics, servo, safety, contact rendering, and an emulated device to try."""
