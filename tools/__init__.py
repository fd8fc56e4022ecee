"""The implementation of dev.py: never part of the extension, and standard library only, except for the charts."""
