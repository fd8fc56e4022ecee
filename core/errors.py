"""The one error a person sees; apart from `base`, so that the servo process has it without numpy."""


class DimpleError(ValueError):
    """Say what is wrong, where, and what to do, in words an artist can use."""
