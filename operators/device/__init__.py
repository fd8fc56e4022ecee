"""Connect a haptic device and place it in the scene."""
