"""Japanese of every message of core and the operators; {} is where a value goes, numbered where the order differs."""

from . import body, devices, reading, verbs

MESSAGES = body.MESSAGES | reading.MESSAGES | devices.MESSAGES | verbs.MESSAGES
