"""The post office: a bounded queue for each channel, tries again later, and keeps to the rate.

What comes faster than a channel's rate goes as one message that lists it. Nothing here ever holds up an alarm.
"""

from __future__ import annotations

import asyncio
import contextlib
import logging
from collections import deque
from collections.abc import Awaitable, Callable, Iterable, Sequence
from dataclasses import dataclass, field
from datetime import datetime

from hmi.clock import Clock
from hmi.domain.alarm.priority import Priority
from hmi.notifications.channel import Channel
from hmi.notifications.errors import NotDelivered, NotificationError
from hmi.notifications.message import Message, Told, merged

WAIT_S = (2.0, 10.0, 30.0, 120.0, 300.0)
MAX_WAITING = 200
BURST = 5.0
CRITICAL_BURST = 10.0  # what is critical may overdraw the rate by so many messages
TEST_LIMIT_S = 20.0
Deliver = Callable[[Channel, Message], Awaitable[None]]
log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class ChannelHealth:
    """How a channel does; counts are since the start of the console."""

    waiting: int
    sent: int
    failed: int
    dropped: int
    last_error: str
    last_sent_at: datetime | None
    failing_since_s: float | None


@dataclass(slots=True)
class _Tried:
    """A message that is sent, and how often that failed: what joins it later has all of its own tries."""

    message: Message
    tries: int = 0


@dataclass(slots=True)
class _Box:
    channel: Channel
    tokens: float
    filled_s: float
    waiting: deque[Message] = field(default_factory=deque)
    again: list[_Tried] = field(default_factory=list)
    sending: asyncio.Task[None] | None = None
    due_s: float = 0.0
    sent: int = 0
    failed: int = 0
    dropped: int = 0
    last_error: str = ""
    last_sent_at: datetime | None = None
    failing_since_s: float | None = None

    def fill(self, now_s: float) -> None:
        """Let the allowance grow with time."""
        grown = (now_s - self.filled_s) * self.channel.per_hour / 3600
        self.tokens, self.filled_s = min(BURST, self.tokens + grown), now_s

    def change(self, channel: Channel) -> None:
        """Use the channel as it is now: what waits was meant for where it went before, and while it was on."""
        if not channel.is_on or channel.way != self.channel.way:
            self.waiting.clear()
            self.again = []
        if not channel.is_on or not _is_same(channel, self.channel):
            self.works()
        self.channel = channel
        self.due_s = 0.0  # it may work now

    def works(self) -> None:
        """Note that nothing is known against it any more."""
        self.failing_since_s, self.last_error = None, ""


def _is_same(one: Channel, other: Channel) -> bool:
    return (one.way, one.secret) == (other.way, other.secret)


class PostOffice:
    """Takes messages on the event loop and sends them in a task of its own.

    Args:
        deliver: sends once.
    """

    def __init__(self, clock: Clock, deliver: Deliver) -> None:
        self._clock, self._deliver = clock, deliver
        self._boxes: dict[str, _Box] = {}
        self._wake = asyncio.Event()
        self._task: asyncio.Task[None] | None = None

    def set_channels(self, channels: Iterable[Channel]) -> None:
        """Use these from now on; what waits for one that is gone, is off or goes elsewhere is forgotten."""
        now_s = self._clock.mono_s()
        before, self._boxes = self._boxes, {}
        for one in channels:
            box = before.get(one.id) or _Box(one, BURST, now_s)
            box.change(one)
            self._boxes[one.id] = box
        self._wake.set()

    def channels(self) -> list[Channel]:
        """Return the channels in use."""
        return [box.channel for box in self._boxes.values()]

    def tell(self, farm: str, told: Told) -> None:
        """Hand over one step of one alarm to every channel that wants it; never blocks, never fails."""
        for box in self._boxes.values():
            if not box.channel.wants(told.what, told.priority, told.source):
                continue
            box.waiting.append(Message(farm, (told,)))
            if len(box.waiting) > MAX_WAITING:
                # the most urgent and the newest is what matters: max finds the oldest of the least urgent
                del box.waiting[max(range(len(box.waiting)), key=lambda i: box.waiting[i].priority)]
                box.dropped += 1
            if told.priority is Priority.CRITICAL:
                box.due_s = 0.0  # it does not wait for what failed before it
            self._wake.set()

    async def test(self, channel: Channel, farm: str) -> str:
        """Send a test once, outside queue and rate; return an empty text, or what went wrong."""
        try:
            await asyncio.wait_for(self._deliver(channel, Message(farm, (), is_test=True)), TEST_LIMIT_S)
        except TimeoutError:
            return f"No answer within {TEST_LIMIT_S:.0f} s."
        except NotificationError as error:
            return error.text
        box = self._boxes.get(channel.id)
        if box is not None and _is_same(channel, box.channel):
            box.works()
        return ""

    def health(self) -> dict[str, ChannelHealth]:
        """Return how each channel does."""
        return {
            name: ChannelHealth(
                len(box.waiting) + len(box.again), box.sent, box.failed, box.dropped, box.last_error,
                box.last_sent_at, box.failing_since_s,
            )
            for name, box in self._boxes.items()
        }  # fmt: skip

    def start(self) -> None:
        """Begin to send."""
        self._task = asyncio.create_task(self._run(), name="notifications")

    async def stop(self) -> None:
        """End; what waits is forgotten: an old alarm by mail helps nobody."""
        tasks = [self._task, *(box.sending for box in self._boxes.values())]
        for task in (one for one in tasks if one is not None):
            task.cancel()
            with contextlib.suppress(asyncio.CancelledError):
                await task

    async def _run(self) -> None:
        while True:
            self._wake.clear()
            self._begin_due()
            wait_s = self._next_s()
            with contextlib.suppress(TimeoutError):  # wait_for may swallow a cancellation that comes with a wake
                async with asyncio.timeout(wait_s):
                    await self._wake.wait()

    async def send_due(self) -> None:
        """Send what may go now and wait until it went or failed."""
        await asyncio.gather(*self._begin_due())

    def _begin_due(self) -> list[asyncio.Task[None]]:
        """Begin to send what may go now: each channel in a task of its own, for one that hangs holds up no other."""
        begun = []
        for box in self._boxes.values():
            if self._is_ready(box):
                box.sending = asyncio.create_task(self._send(box), name=f"notification by {box.channel.id}")
                box.sending.add_done_callback(lambda _: self._wake.set())
                begun.append(box.sending)
        return begun

    def _is_ready(self, box: _Box) -> bool:
        now_s = self._clock.mono_s()
        box.fill(now_s)
        is_busy = box.sending is not None and not box.sending.done()
        if is_busy or not (box.waiting or box.again) or now_s < box.due_s or not box.channel.is_on:
            return False
        urgent = any(one.priority is Priority.CRITICAL for one in (*box.waiting, *(one.message for one in box.again)))
        return box.tokens >= 1 or (urgent and box.tokens > -CRITICAL_BURST)

    async def _send(self, box: _Box) -> None:
        box.again += [_Tried(one) for one in box.waiting]
        box.waiting.clear()
        message = box.again[0].message if len(box.again) == 1 else merged([one.message for one in box.again])
        box.tokens -= 1
        used = box.channel
        try:
            await self._deliver(used, message)
        except NotificationError as error:
            self._failed(box, used, error)
        except Exception as error:  # a mistake of ours must not silence the other channels
            log.exception("channel %s failed", box.channel.id)
            self._failed(box, used, NotDelivered(f"{type(error).__name__}.", is_lasting=True))
        else:
            box.again = []
            if _is_same(used, box.channel):
                box.works()
            box.sent, box.last_sent_at = box.sent + 1, self._clock.utc()

    def _failed(self, box: _Box, used: Channel, error: NotificationError) -> None:
        now_s = self._clock.mono_s()
        log.warning("notification by %s: %s", used.name, error.text)
        if box.channel.is_on and _is_same(used, box.channel):  # else it is no news of the channel as it is now
            box.last_error = error.text
            box.failing_since_s = now_s if box.failing_since_s is None else box.failing_since_s
        is_lasting = not isinstance(error, NotDelivered) or error.is_lasting
        for one in box.again:
            one.tries += 1
        kept = [] if is_lasting else [one for one in box.again if one.tries <= len(WAIT_S)]
        if len(kept) < len(box.again):
            box.failed += 1
        box.again = kept
        # by the newest of it; what is critical and came meanwhile goes at once
        is_urgent = any(one.priority is Priority.CRITICAL for one in box.waiting)
        if kept and not is_urgent:
            box.due_s = now_s + WAIT_S[min(one.tries for one in kept) - 1]

    def _next_s(self) -> float:
        boxes: Sequence[_Box] = [box for box in self._boxes.values() if box.waiting or box.again]
        return 1.0 if boxes else 3600.0
