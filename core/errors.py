"""The one error an artist sees; apart from `base`, so that the servo process needs no numpy."""

from typing import Any

from .messages import Message

LARGEST = 1e12  # in any SI unit: what is larger is taken for a mistake; its cube is all that single precision holds


class DimpleError(ValueError):
    """Its message says what is wrong, where, and what to do, in an artist's words.

    Args:
        template, values: as of a Message, or a message.
    """

    def __init__(self, template: str, /, **values: Any) -> None:
        super().__init__(Message(template, **values))

    def __str__(self) -> str:
        """Return the message."""
        return self.args[0]
