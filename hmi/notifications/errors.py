"""Why a notification did not go out.

::

    NotificationError
    ├── BadAddress        where it should go is not allowed
    ├── BadChannel        what was set cannot be used
    └── NotDelivered      the other side did not take it
"""

from __future__ import annotations


class NotificationError(Exception):
    """Root of the errors of ``hmi.notifications``.

    Args:
        text: one sentence for a person; never holds a secret.
    """

    def __init__(self, text: str) -> None:
        super().__init__(text)
        self.text = text


class BadAddress(NotificationError):
    """The address is not allowed."""


class BadChannel(NotificationError):
    """What was set cannot be used."""

    def __init__(self, text: str, field: str) -> None:
        super().__init__(text)
        self.field = field


class NotDelivered(NotificationError):
    """The other side did not take it; ``is_lasting`` says that trying again cannot help."""

    def __init__(self, text: str, *, is_lasting: bool = False) -> None:
        super().__init__(text)
        self.is_lasting = is_lasting
