"""The one error that an artist sees; not in `base`, because the servo process has no numpy."""

from typing import Any

from .message import Message

LARGEST = 1e12  # in any SI unit: a larger number is a mistake, and its cube overflows single precision


class DimpleError(ValueError):
    """An error whose message says, in an artist's words, what is wrong, where, and what to do.

    Args:
        template, values: those of a Message; or a Message alone.
    """

    def __init__(self, template: str, /, **values: Any) -> None:
        super().__init__(Message(template, **values))

    def __str__(self) -> str:
        """Return the message."""
        return self.args[0]
