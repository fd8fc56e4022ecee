"""The one error an artist sees; apart from `base`, so that the servo process needs no numpy."""


class DimpleError(ValueError):
    """Its message says what is wrong, where, and what to do, in an artist's words."""
