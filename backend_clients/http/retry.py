"""When to ask again: back-off with jitter, a deadline, and a budget that keeps retries from piling up."""

from __future__ import annotations

import random
from collections.abc import Mapping
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class RetryPolicy:
    """How often and how long one call tries.

    Args:
        attempts: at most so many, the first one included.
        first_s: the longest first pause; each further one may be twice as long.
        longest_s: no pause is longer, whatever the service asks for.
        deadline_s: no attempt begins after so long.
    """

    attempts: int = 4
    first_s: float = 0.2
    longest_s: float = 5.0
    deadline_s: float = 15.0

    def pause_s(self, attempt: int, asked_s: float | None, chance: float | None = None) -> float:
        """Return how long to wait after ``attempt`` (from 1); ``asked_s`` is the service's wish."""
        jitter = random.random() if chance is None else chance  # noqa: S311 (spreads load, keeps no secret)
        own = min(self.first_s * 2.0 ** (attempt - 1), self.longest_s) * jitter
        return min(max(own, asked_s or 0.0), self.longest_s)


class RetryBudget:
    """Lets retries be a fifth of all calls over time, with a reserve: a service in trouble is not buried.

    Args:
        reserve: retries that may come at once.
        share: what each call puts back.
    """

    def __init__(self, reserve: float = 10.0, share: float = 0.2) -> None:
        self._reserve, self._share = reserve, share
        self._left = reserve

    def called(self) -> None:
        """Count a call."""
        self._left = min(self._reserve, self._left + self._share)

    def take(self) -> bool:
        """Take one retry out; ``False`` if there is none left."""
        if self._left < 1:
            return False
        self._left -= 1
        return True


def asked_pause_s(headers: Mapping[str, str]) -> float | None:
    """Return how long a service asks to be left alone, seconds; a date instead of them is not read."""
    text = headers.get("retry-after", "")
    return float(text) if text.isascii() and text.isdigit() and len(text) < 8 else None
