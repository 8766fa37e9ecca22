"""Runs one kind of work after another: one that fails as nobody foresaw is seen, and holds up none of the others."""

from __future__ import annotations

import logging
from collections.abc import Awaitable, Callable

MAX_TEXT = 200
log = logging.getLogger(__name__)


class Guard:
    """Keeps what failed unexpectedly, by kind of work, until it goes well again."""

    def __init__(self) -> None:
        self.trouble: dict[str, str] = {}

    async def run(self, what: str, work: Callable[[], Awaitable[bool]]) -> bool:
        """Do it and return what it returns: whether the link is still up. One that fails leaves the link as it is."""
        try:
            is_up = await work()
        except Exception as error:  # what comes after it must come whatever one value is
            text = f"{type(error).__name__}: {error}"[:MAX_TEXT]
            if self.trouble.get(what) != text:  # a database that is away is told once, not each second
                log.exception("cloud: %s failed", what)
            self.trouble[what] = text
            return True
        if is_up:
            self.trouble.pop(what, None)
        return is_up

    @property
    def text(self) -> str:
        """What does not go up and why, empty if everything does."""
        return " ".join(f"{what}: {why}" for what, why in self.trouble.items())
