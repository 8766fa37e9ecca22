"""What a failed call means for the way to a service as a whole."""

from __future__ import annotations

from enum import StrEnum

from backend_clients.errors import ClientError


class Trouble(StrEnum):
    """Kinds of failure that mean the same whatever service it is; each error of a client has one."""

    UNREACHABLE = "unreachable"
    SILENT = "silent"
    UNTRUSTED = "untrusted"
    REFUSED = "refused"
    FAILING = "failing"
    BUSY = "busy"
    NARROW = "narrow"
    """What stands before the service takes only small requests, smaller than ours can be."""
    NOT_UNDERSTOOD = "not_understood"
    MISSET = "misset"
    """What was asked for can never be sent: of a setting, a person has to change it."""


PASSING = frozenset({Trouble.UNREACHABLE, Trouble.SILENT, Trouble.BUSY})
"""The same request may succeed a little later; of a service that fails, its status says so."""
PASSING_STATUS = frozenset({500, 502, 503, 504})


class OutsideError(ClientError):
    """Root of what can go wrong with a service outside.

    Attributes:
        trouble: what it means for the way there; ``None``: it is about this request alone.
        mend: one sentence for whoever has to repair it.
        retry_after_s: how long the service asks to be left alone, seconds.
    """

    trouble: Trouble | None = None
    mend = "Look at the log of the service."
    retry_after_s: float | None = None


def is_passing(error: OutsideError) -> bool:
    """Say whether the same request may succeed a little later."""
    if error.trouble is Trouble.FAILING:
        return getattr(error, "status", 0) in PASSING_STATUS
    return error.trouble in PASSING
