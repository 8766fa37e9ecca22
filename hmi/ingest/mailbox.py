"""Hands raw payloads from the MQTT thread to the event loop, in bounded memory.

State is conflated: only the newest payload per (robot, kind) waits. What happened once (acknowledgements,
events, presence, nodes) waits in order in a bounded queue; its overflow is counted, never silent.
What a newer payload replaced is handed over too, as far as there is room, so that it does not count as lost on the way.
Nothing is decoded here, so that no payload can harm the network thread.
"""

from __future__ import annotations

import asyncio
import threading
from collections import deque
from collections.abc import Callable
from functools import lru_cache
from itertools import islice
from typing import NamedTuple

from backend_clients.edge.topics import Address, Down, Up, parse
from backend_clients.errors import WireError, WrongIdentity

CADENCE_S = 0.025  # a drain at most this often; the first frame after a pause is drained at once
FIFO_LIMIT = 10_000  # 2.5 s of a fleet that sends nothing but events at 4,000 a second
KEY_LIMIT = 50_000  # 5,000 robots x 8 kinds and some that nobody registered; keys beyond it are refused and counted
REPLACED_BYTES = 4 * 2**20  # a fifth of a second of a thousand robots
LETTER_BYTES = 150  # beside the payload
_address_of = lru_cache(maxsize=KEY_LIMIT)(parse)  # the same few topics come ten times a second
CONFLATED = frozenset(
    {Up.FACTSHEET, Up.HEARTBEAT, Up.TELEMETRY, Up.STATE, Up.SAFETY, Up.BODY, Up.WORKSITE, Up.DETECTIONS}
)


class Letter(NamedTuple):
    """One raw message and when the network thread had it, in monotonic seconds."""

    address: Address
    payload: bytes
    received_s: float
    is_retained: bool


class Batch(NamedTuple):
    """What one drain takes out: discrete messages in order, then the newest state per key.

    Args:
        replaced: older state, in order, which only its number is read of.
        unread: whose messages found no room, so that nobody has their numbers.
        is_more: something waits still.
    """

    discrete: list[Letter]
    state: list[Letter]
    lost: int
    refused: dict[str, int]
    replaced: list[Letter]
    unread: set[Address]
    is_more: bool = False


class Mailbox:
    """Between one network thread and one event loop.

    Args:
        loop: where ``on_mail`` runs.
        on_mail: called on the loop when there is something to ``take``; once, until all of it was taken.
        mono_s: the console's monotonic clock; called on the network thread.
    """

    def __init__(
        self,
        loop: asyncio.AbstractEventLoop,
        on_mail: Callable[[], None],
        mono_s: Callable[[], float],
        *,
        fifo_limit: int = FIFO_LIMIT,
        key_limit: int = KEY_LIMIT,
    ) -> None:
        self._loop, self._on_mail, self._mono_s = loop, on_mail, mono_s
        self._fifo_limit, self._key_limit = fifo_limit, key_limit
        self._lock = threading.Lock()
        self._state: dict[Address, Letter] = {}
        self._discrete: deque[Letter] = deque()
        self._replaced: list[Letter] = []
        self._replaced_bytes = 0
        self._unread: set[Address] = set()
        self._refused: dict[str, int] = {}
        self._lost = 0
        self._is_called = False
        self._is_closed = False

    def post(self, topic: str, payload: bytes, is_retained: bool) -> None:
        """Take one message; any thread, any bytes, never raises for what is in them."""
        received_s = self._mono_s()
        try:
            address = _address_of(topic)
            if isinstance(address.kind, Down):
                raise WrongIdentity(f"{topic} is a topic of the console")
        except WireError:
            self._refuse("bad_topic")
            return
        letter = Letter(address, payload, received_s, is_retained)
        with self._lock:
            self._keep(letter)
            if self._is_called or self._is_closed:
                return
            self._is_called = True
        self._call()

    def take(self, most: int = FIFO_LIMIT + KEY_LIMIT) -> Batch:
        """Take what waited longest out of the box, at most ``most`` of what happened and of states; on the loop."""
        with self._lock:
            discrete = [self._discrete.popleft() for _ in range(min(most, len(self._discrete)))]
            state = [self._state.pop(key) for key in list(islice(self._state, most))]
            is_more = bool(self._discrete or self._state)
            batch = Batch(discrete, state, self._lost, self._refused, self._replaced, self._unread, is_more)
            self._lost, self._refused = 0, {}
            self._replaced, self._replaced_bytes, self._unread = [], 0, set()
            self._is_called = is_more  # whoever left something comes again by itself
        return batch

    def close(self) -> None:
        """Stop calling the loop; what still comes is kept within the limits and forgotten."""
        with self._lock:
            self._is_closed = True

    def _keep(self, letter: Letter) -> None:
        if letter.address.kind not in CONFLATED:
            if len(self._discrete) >= self._fifo_limit:
                oldest = self._discrete.popleft()  # the newest acknowledgement matters more than the oldest
                self._unread.add(oldest.address)
                self._lost += 1
            self._discrete.append(letter)
        elif letter.address in self._state:
            self._replace(self._state[letter.address])
            self._state[letter.address] = letter
        elif len(self._state) < self._key_limit:
            self._state[letter.address] = letter
        else:
            self._refused["too_many_keys"] = self._refused.get("too_many_keys", 0) + 1

    def _replace(self, older: Letter) -> None:
        self._replaced_bytes += len(older.payload) + LETTER_BYTES
        if self._replaced_bytes <= REPLACED_BYTES:
            self._replaced.append(older)
        else:
            self._unread.add(older.address)

    def _refuse(self, reason: str) -> None:
        with self._lock:
            self._refused[reason] = self._refused.get(reason, 0) + 1

    def _call(self) -> None:
        try:
            self._loop.call_soon_threadsafe(self._on_mail)
        except RuntimeError:  # the loop has ended; nobody is left to read
            self.close()
