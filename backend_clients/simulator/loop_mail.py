"""Hands work from network threads to the event loop, one wake-up for many pieces.

Each ``call_soon_threadsafe`` writes a byte into the loop's pipe; a thousand pings at once would fill it, and a signal
that comes then is lost.
"""

from __future__ import annotations

import asyncio
import threading
from collections import deque
from collections.abc import Callable


class LoopMail:
    """Pieces of work in the order they were posted."""

    def __init__(self, loop: asyncio.AbstractEventLoop) -> None:
        self._loop = loop
        self._waiting: deque[Callable[[], None]] = deque()
        self._lock = threading.Lock()
        self._is_due = False

    def post(self, work: Callable[[], None]) -> None:
        """Run ``work`` on the loop; dropped when the loop has ended. Safe from any thread."""
        with self._lock:
            self._waiting.append(work)
            is_first, self._is_due = not self._is_due, True
        if is_first and not self._loop.is_closed():
            self._loop.call_soon_threadsafe(self._deliver)

    def _deliver(self) -> None:
        with self._lock:
            works, self._waiting, self._is_due = self._waiting, deque(), False
        for work in works:
            try:
                work()
            except Exception as error:  # noqa: BLE001 - one robot's trouble is not another's; asyncio reports it
                self._loop.call_exception_handler({"message": "work posted by a thread failed", "exception": error})
