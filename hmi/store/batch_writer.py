"""A thread that writes in batches what others hand it without ever waiting.

``put`` costs one lock and one append. When the database is slow, locked or its disk full, the queue fills up to its
capacity, then further items are dropped and counted; nobody who hands in something ever blocks or fails.
"""

from __future__ import annotations

import logging
import threading
import time
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Generic, TypeVar

from hmi.store.errors import DatabaseUnavailable

T = TypeVar("T")
_LATER = (DatabaseUnavailable, OSError)
logger = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class WriterHealth:
    """How a writer is doing; counts are since the start of the process."""

    name: str
    is_ok: bool
    queued: int
    capacity: int
    written: int
    dropped: int
    last_error: str


class BatchWriter(Generic[T]):
    """One writer thread with a bounded queue.

    Args:
        name: name of the thread and in health.
        write: called in the thread with a batch. ``DatabaseUnavailable`` and ``OSError`` keep the batch for another
            try after ``retry_s``; after any other error its items are tried one by one and the bad ones dropped.
        capacity: most items waiting at any time.
        batch_size: most items in one call of ``write``.
        linger_s: how long to gather a batch before writing it; 0 writes at once.
        on_idle: called in the thread when nothing waits; returns whether to be called again after ``retry_s``.
    """

    def __init__(
        self,
        name: str,
        write: Callable[[Sequence[T]], None],
        *,
        capacity: int,
        batch_size: int = 1000,
        linger_s: float = 0.0,
        retry_s: float = 1.0,
        on_idle: Callable[[], bool] = lambda: False,
    ) -> None:
        self._name = name
        self._write = write
        self._capacity = capacity
        self._batch_size = batch_size
        self._linger_s = linger_s
        self._retry_s = retry_s
        self._on_idle = on_idle
        self._queue: deque[T] = deque()
        self._changed = threading.Condition()
        self._taken = self._put = self._written = self._dropped = 0
        self._last_error = ""
        self._is_closing = False
        self._flush_target = 0
        self._thread: threading.Thread | None = None

    def start(self) -> None:
        """Start the thread; a second call does nothing."""
        if self._thread is None:
            self._thread = threading.Thread(target=self._run, name=self._name, daemon=True)
            self._thread.start()

    def put(self, item: T) -> bool:
        """Hand over one item from any thread; False means that it was dropped, and counted."""
        with self._changed:
            if len(self._queue) >= self._capacity or self._is_closing:
                self._dropped += 1
                return False
            self._queue.append(item)
            self._put += 1
            if len(self._queue) == 1 or len(self._queue) >= self._batch_size:
                self._changed.notify_all()
            return True

    def flush(self, timeout_s: float) -> bool:
        """Wait until everything handed over so far is written; False if that took too long. Blocks."""
        with self._changed:
            target = self._flush_target = self._put
            self._changed.notify_all()
            return self._changed.wait_for(lambda: self._taken >= target, timeout_s)

    def close(self, timeout_s: float) -> bool:
        """Write what waits and end the thread; False if something could not be written in time. Blocks."""
        with self._changed:
            self._is_closing = True
            self._changed.notify_all()
        if self._thread is not None:
            self._thread.join(timeout_s)
        return not self._queue and (self._thread is None or not self._thread.is_alive())

    def health(self) -> WriterHealth:
        """Return counts and the newest error; ``is_ok`` is False while writing fails or the thread is dead."""
        with self._changed:
            is_running = self._thread is not None and self._thread.is_alive()
            return WriterHealth(
                self._name, is_running and not self._last_error, len(self._queue), self._capacity, self._written,
                self._dropped, self._last_error,
            )  # fmt: skip

    def _run(self) -> None:
        while self._wait_for_work():
            batch = self._peek()
            if batch and not self._attempt(batch) and self._rest():
                return

    def _wait_for_work(self) -> bool:
        """Return True when there is something to write, False when the thread should end."""
        while True:
            again = self._idle() if not self._queue else False
            with self._changed:
                if not self._queue and not self._is_closing:
                    self._changed.wait(self._retry_s if again else None)
                if self._queue:
                    self._linger()
                    return True
                if self._is_closing:
                    return False

    def _linger(self) -> None:
        until_s = time.monotonic() + self._linger_s
        while len(self._queue) < self._batch_size and not self._is_closing and self._flush_target <= self._taken:
            left_s = until_s - time.monotonic()
            if left_s <= 0:
                return
            self._changed.wait(left_s)

    def _peek(self) -> list[T]:
        with self._changed:
            return [self._queue[index] for index in range(min(len(self._queue), self._batch_size))]

    def _attempt(self, batch: list[T]) -> bool:
        """Write a batch; False if it is kept for later."""
        try:
            self._write(batch)
        except _LATER as error:
            self._note(str(error))
            return False
        except Exception:
            if len(batch) > 1:
                return all(self._attempt([item]) for item in batch)
            logger.exception("%s drops an item that cannot be written at all", self._name)
            self._take(batch, written=0)
            return True
        self._take(batch, written=len(batch))
        self._note("")
        return True

    def _take(self, batch: list[T], written: int) -> None:
        with self._changed:
            for _ in batch:
                self._queue.popleft()
            self._taken += len(batch)
            self._written += written
            self._dropped += len(batch) - written
            self._changed.notify_all()

    def _idle(self) -> bool:
        try:
            return self._on_idle()
        except Exception as error:  # noqa: BLE001 - as above
            self._note(str(error))
            return True

    def _rest(self) -> bool:
        """Wait before the next try; True when closing, so that a full disk does not hold up the end."""
        with self._changed:
            self._changed.wait_for(lambda: self._is_closing, self._retry_s)
            return self._is_closing

    def _note(self, error: str) -> None:
        if error and not self._last_error:
            logger.error("%s cannot write: %s", self._name, error)
        elif self._last_error and not error:
            logger.info("%s writes again", self._name)
        self._last_error = error
