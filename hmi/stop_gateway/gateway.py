"""The gateway's parts put together: dispatcher, browsers, outbox, and the tasks that keep them going."""

from __future__ import annotations

import asyncio
import logging
import secrets
import threading
from collections.abc import Awaitable, Callable, Sequence
from typing import Any

from hmi import __version__
from hmi.clock import Clock
from hmi.domain.stop import StopAttempt
from hmi.domain.stop_token import BadStopToken, StopToken
from hmi.settings import Settings
from hmi.stop_gateway.dispatcher import StopDispatcher
from hmi.stop_gateway.errors import TokenRefused
from hmi.stop_gateway.frames import encode
from hmi.stop_gateway.hub import Client, Hub
from hmi.stop_gateway.outbox import Outbox
from hmi.stop_gateway.registry import LOOK_S, Registry

HEARTBEAT_S = 0.25  # 4 Hz: a browser calls the path gone after 1.5 s
FULL_EVERY = 4  # with many robots their lines come at 1 Hz, ages run on in the browser
MANY_ROBOTS = 50
NOT_ENROLLED = "This tablet is not enrolled. STOP does not work here."
_log = logging.getLogger("headland.stop")


class Gateway:
    """Everything of the STOP gateway but its sockets.

    Args:
        settings: of the installation; the STOP folder is ``settings.data / "stop"``.
        clock: where the time comes from.
    """

    def __init__(self, settings: Settings, clock: Clock) -> None:
        folder = settings.data / "stop"
        ca_file = str(settings.broker_ca) if settings.broker_ca else None
        self._settings = settings
        self._clock = clock
        self._outbox = Outbox(folder / "outbox.json", clock)
        self._is_unsaved = asyncio.Event()
        self._tasks: list[asyncio.Task[None]] = []
        self.boot = secrets.token_hex(8)
        self.hub = Hub()
        self.dispatcher = StopDispatcher(
            clock, Registry(folder), self._moved_on, settings.broker_url, broker_ca=ca_file
        )

    async def start(self) -> None:
        """Load what is on disk, connect, and go on with presses of before a restart."""
        await self.dispatcher.refresh()
        self.dispatcher.restore(await asyncio.to_thread(self._outbox.load))
        self.dispatcher.wire.start()
        for work in (self.dispatcher.run, self.dispatcher.ping, self._beat, self._save, self._look):
            self._tasks.append(asyncio.create_task(self._kept(work), name=f"stop-{work.__name__}"))

    async def stop(self) -> None:
        """Send browsers away, write the outbox, end tasks and connections; well under a second."""
        self.hub.close()
        for task in self._tasks:
            task.cancel()
        await asyncio.gather(*self._tasks, return_exceptions=True)
        await asyncio.to_thread(self._outbox.save, self.dispatcher.book.attempts())
        await self.dispatcher.close()
        # paho may be in the middle of a reconnect pause of seconds; its thread is a daemon and may be left behind
        ending = threading.Thread(target=self.dispatcher.wire.stop, daemon=True)
        ending.start()
        await asyncio.to_thread(ending.join, 0.3)

    def admit(self, text: str) -> StopToken:
        """Return who presses; raises ``TokenRefused``."""
        try:
            token = StopToken.read(text, self._settings.secret)
        except BadStopToken as error:
            raise TokenRefused(NOT_ENROLLED) from error
        if self.dispatcher.registry.is_revoked(token.device_id):
            raise TokenRefused("This tablet was taken out of use. STOP does not work here.")
        return token

    def press(self, stop_id: str, robots: Sequence[str] | str, token: StopToken) -> list[dict[str, Any]]:
        """Send STOP; return the steps."""
        return self.dispatcher.press(stop_id, robots, token)

    def greet(self, client: Client, token: StopToken) -> None:
        """Tell a browser that has just come everything it has to know, and keep it told."""
        hello = {"k": "hello", "boot": self.boot, "device": token.device_name, "user": token.user_name}
        client.tell("hello", encode(hello))
        client.tell("robots", encode(self._cards()))
        for step in self.dispatcher.steps():
            client.tell((step["stop_id"], step["robot"]), encode(step))
        client.tell("hb", encode(self._heartbeat(0, is_full=True)))
        self.hub.join(client)

    def health(self) -> dict[str, Any]:
        """Return the gateway's health, without the process id."""
        is_up = self.dispatcher.wire.is_up
        return {
            "status": "ok" if is_up else "degraded",
            "version": __version__,
            "broker": "up" if is_up else "down",
            "robots": len(self.dispatcher.registry.robots),
            "clients": len(self.hub),
            "open_presses": len(self.dispatcher.book),
            "faults": self.dispatcher.wire.faults,
        }

    def _moved_on(self, attempts: list[StopAttempt]) -> None:
        now_s = self._clock.mono_s()
        self.hub.steps([attempt.step(now_s) for attempt in attempts])
        self._is_unsaved.set()

    def _cards(self) -> dict[str, Any]:
        robots = self.dispatcher.registry.robots
        return {"k": "robots", "robots": {robot_id: entry.card() for robot_id, entry in robots.items()}}

    def _heartbeat(self, number: int, *, is_full: bool) -> dict[str, Any]:
        frame = {"k": "hb", "n": number, "broker": "up" if self.dispatcher.wire.is_up else "down"}
        return {**frame, "robots": self.dispatcher.heartbeat()} if is_full else frame

    async def _beat(self) -> None:
        number = 0
        while True:
            await asyncio.sleep(HEARTBEAT_S)
            number += 1
            is_full = len(self.dispatcher.registry.robots) <= MANY_ROBOTS or number % FULL_EVERY == 0
            if len(self.hub):
                # a light beat must not replace a full one that a slow browser has still to read
                self.hub.tell(("hb", is_full), self._heartbeat(number, is_full=is_full))

    async def _save(self) -> None:
        while True:
            await self._is_unsaved.wait()
            self._is_unsaved.clear()
            try:
                await asyncio.to_thread(self._outbox.save, self.dispatcher.book.attempts())
            except (OSError, RuntimeError) as error:  # the latter where the system has no room for a thread
                _log.error("the STOP outbox cannot be written: %s", error)
                await asyncio.sleep(1.0)
                self._is_unsaved.set()

    async def _look(self) -> None:
        while True:
            await asyncio.sleep(LOOK_S)
            if self.dispatcher.wire.look_after():
                _log.error("a network thread had died and was started again")
            if await self.dispatcher.refresh():
                self.hub.tell("robots", self._cards())

    async def _kept(self, work: Callable[[], Awaitable[None]]) -> None:
        """Run one of the endless tasks; one that fails is started again, for STOP must not end by a bug in it."""
        while True:
            try:
                await work()
            except Exception:  # noqa: BLE001 - the outer loop of a task, logged
                _log.exception("%s failed and starts again", work.__name__)
                await asyncio.sleep(0.1)
