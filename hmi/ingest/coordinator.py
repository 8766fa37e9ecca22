"""The only owner of the console's broker connection: from raw payloads to the fleet store.

Whatever arrives is counted or applied; nothing that a robot, a broker or a stranger sends ends this.
"""

from __future__ import annotations

import asyncio
import contextlib
import logging
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from datetime import timedelta
from functools import partial
from typing import Any, Protocol

from backend_clients.edge import machine
from backend_clients.edge import messages_up as up
from backend_clients.edge.codec import decode_body, header_of
from backend_clients.edge.mqtt import LinkState, MqttLink, OnLink, OnMessage
from backend_clients.edge.topics import Address, Up, every_robot
from backend_clients.errors import MalformedPayload, OversizedPayload, WireError, WrongIdentity
from hmi.clock import Clock
from hmi.domain.command import Acknowledgement
from hmi.domain.event import RobotEvent
from hmi.domain.robot import SafetyState, Stamp
from hmi.ingest import translate, translate_machine
from hmi.ingest.arrivals import Arrivals
from hmi.ingest.mailbox import CADENCE_S, FIFO_LIMIT, Letter, Mailbox
from hmi.ingest.pinger import Pinger
from hmi.ingest.robot_clock import Refusal, RobotClock
from hmi.ingest.tally import Tally
from hmi.store.fleet import FleetStore

log = logging.getLogger(__name__)

WATCH_S = 0.5  # how often silence and the network thread are looked at
PING_SLOT_S = 0.05
LETTERS_A_TURN = 200  # some 20 ms; between turns people and their orders get the loop, however many robots talk
# QoS as the contract has it: what happened once is sent at 1, what repeats at 0
# point clouds are for the twin alone, which listens for itself
SUBSCRIPTIONS = [
    (every_robot(kind), 0 if kind in (Up.HEARTBEAT, Up.TELEMETRY, Up.BODY, Up.DETECTIONS) else 1)
    for kind in Up
    if kind is not Up.SCAN
]
_REASONS: dict[type[WireError], str] = {
    MalformedPayload: "malformed",
    OversizedPayload: "oversized",
    WrongIdentity: "wrong_identity",
}


class BrokerLink(Protocol):
    """What the coordinator needs of a broker connection; ``MqttLink`` is one."""

    @property
    def is_up(self) -> bool:
        """Whether a publication made now would be sent."""
        ...

    @property
    def is_alive(self) -> bool:
        """Whether its network thread runs."""
        ...

    def start(self) -> None:
        """Connect and keep trying."""
        ...

    def stop(self) -> None:
        """Disconnect; returns when the thread has ended."""
        ...

    def publish(self, topic: str, payload: bytes, *, qos: int = 0, retain: bool = False) -> bool:
        """Send now or not at all."""
        ...


OnFault = Callable[[Exception], None]
MakeLink = Callable[[OnMessage, OnLink, OnFault], BrokerLink]


def mqtt_link(url: str, client_id: str, *, ca_file: str | None = None) -> MakeLink:
    """Return what makes the real connection, subscribed to everything robots say."""

    def make(on_message: OnMessage, on_link: OnLink, on_fault: OnFault) -> BrokerLink:
        return MqttLink(
            url,
            client_id,
            subscriptions=SUBSCRIPTIONS,
            on_message=on_message,
            on_link=on_link,
            on_fault=on_fault,
            ca_file=ca_file,
        )

    return make


@dataclass(slots=True)
class EdgeListeners:
    """Who wants to know at once, each called on the loop; what they raise is logged, not passed on.

    ``on_trouble(code, text)`` tells what an admin must hear: overflow, a dead network thread.
    """

    on_ack: list[Callable[[Acknowledgement], None]] = field(default_factory=list)
    on_event: list[Callable[[RobotEvent], None]] = field(default_factory=list)
    on_safety: list[Callable[[str, SafetyState], None]] = field(default_factory=list)
    on_trouble: list[Callable[[str, str], None]] = field(default_factory=list)


class EdgeCoordinator:
    """Receives all robots of one broker.

    Args:
        make_link: see ``mqtt_link``.
        store: filled by this.
        clock: the console's clocks.
        fifo_limit: how many discrete messages may wait between two drains.
    """

    def __init__(self, make_link: MakeLink, store: FleetStore, clock: Clock, *, fifo_limit: int = FIFO_LIMIT) -> None:
        self._make_link, self._store, self._clock = make_link, store, clock
        self._fifo_limit = fifo_limit
        self._clocks: dict[str, RobotClock] = {}
        self._tasks: list[asyncio.Task[None]] = []
        self._drained_s = float("-inf")
        self._mailbox: Mailbox | None = None
        self._link: BrokerLink | None = None
        self._pinger: Pinger | None = None
        self.listeners = EdgeListeners()
        self.tally = Tally()
        self.arrivals = Arrivals(clock.mono_s)
        self.messages = 0
        self.broker_text = "not started"

    @property
    def link(self) -> BrokerLink:
        """The connection, for those who send; only between ``start`` and ``stop``."""
        if self._link is None:
            raise RuntimeError("the coordinator was not started")
        return self._link

    @property
    def is_broker_up(self) -> bool:
        """Whether the console is connected to the broker now."""
        return self._link is not None and self._link.is_up

    async def start(self) -> None:
        """Connect in the background; the running loop becomes the home of everything here."""
        loop = asyncio.get_running_loop()
        self._mailbox = Mailbox(loop, self._mail_has_come, self._clock.mono_s, fifo_limit=self._fifo_limit)

        def on_link(state: LinkState, text: str) -> None:
            with contextlib.suppress(RuntimeError):  # the loop has ended
                loop.call_soon_threadsafe(self._link_changed, state, text)

        def on_fault(error: Exception) -> None:
            with contextlib.suppress(RuntimeError):
                loop.call_soon_threadsafe(self._thread_fault, error)

        self._link = self._make_link(self._mailbox.post, on_link, on_fault)
        self._pinger = Pinger(self._link, self._clock.mono_s)
        self._link.start()
        self._tasks = [
            asyncio.create_task(self._watch(), name="edge-watch"),
            asyncio.create_task(self._ping(), name="edge-ping"),
        ]

    async def stop(self) -> None:
        """End tasks and connection; returns when the network thread has ended."""
        for task in self._tasks:
            task.cancel()
        await asyncio.gather(*self._tasks, return_exceptions=True)
        self._tasks = []
        if self._mailbox is not None:
            self._mailbox.close()
        if self._link is not None:
            await asyncio.to_thread(self._link.stop)
            self._link = None

    def drain(self) -> None:
        """Apply what is in the mailbox now, all of it; for tests that do not wait."""
        while self._drain_some():
            pass

    def _drain_some(self) -> bool:
        """Apply one turn's share; whether more waits."""
        if self._mailbox is None:
            return False
        batch = self._mailbox.take(LETTERS_A_TURN)
        self._drained_s = self._clock.mono_s()
        for reason, number in batch.refused.items():
            self.tally.count(reason, number=number)
        if batch.lost:
            self.tally.count("overflow", number=batch.lost)
            self._tell(self.listeners.on_trouble, "ingest_overflow", f"{batch.lost} robot messages were lost.")
        for letter in batch.replaced:
            self._number(letter)
        for letter in batch.discrete:
            self._open(letter)
        for letter in batch.state:
            self._open(letter)
        for robot, kind in batch.unread:
            self.arrivals.begin_anew(robot, Up(kind))
        if batch.discrete or batch.state:
            self._store.announce()
        return batch.is_more

    def diagnostics(self) -> dict[str, Any]:
        """Return counters for the diagnostics page."""
        return {
            "broker": "up" if self.is_broker_up else "down",
            "broker_text": self.broker_text,
            "messages": self.messages,
            "refused": dict(self.tally.total),
            "refused_by_robot": self.tally.by_robot(),
            "examples": dict(self.tally.last_text),
        }

    def _mail_has_come(self) -> None:
        # The first message after a pause goes through at once; under load the cadence conflates.
        wait_s = self._drained_s + CADENCE_S - self._clock.mono_s()
        if wait_s <= 0:
            self._turn()
        else:
            asyncio.get_running_loop().call_later(wait_s, self._turn)

    def _turn(self) -> None:
        is_more = True
        try:
            is_more = self._drain_some()
        finally:  # the mailbox calls once until it is empty: without another turn no robot would ever be heard again
            if is_more:
                asyncio.get_running_loop().call_soon(self._turn)

    def _open(self, letter: Letter) -> None:
        robot = letter.address.robot
        self.messages += 1
        try:
            message = decode_body(letter.address, letter.payload)
        except WireError as error:
            self.tally.count(_REASONS.get(type(error), "malformed"), robot, str(error))
            self._arrived(letter, None)
            return
        if not self._store.admit(robot):
            self.tally.count("too_many_robots", robot)
            return
        self._arrived(letter, message)
        try:
            self._apply(letter, message)
        except Refusal as refusal:
            self.tally.count(refusal.reason, robot)
        except Exception:  # one bad robot must not silence the others
            log.exception("applying %s of %s failed", letter.address.kind, robot)
            self.tally.count("internal_error", robot)

    def _number(self, letter: Letter) -> None:
        with contextlib.suppress(WireError):
            self._arrived(letter, header_of(letter.address, letter.payload))

    def _arrived(self, letter: Letter, header: Any) -> None:
        """Count a message, whether or not it may count for anything else; without a header it could not be read."""
        robot, kind = letter.address
        if letter.is_retained or self._store.registration(robot) is None:  # a retained copy was sent long ago
            return
        assert isinstance(kind, Up)
        if header is None:
            self.arrivals.begin_anew(robot, kind)
        else:
            self.arrivals.take(robot, kind, header, letter.received_s)

    def _apply(self, letter: Letter, message: Any) -> None:
        address = letter.address
        assert isinstance(address.kind, Up)
        clock = self._clocks.get(address.robot)
        if clock is None:
            clock = self._clock_of(address.robot)
        stamp = clock.admit(address.kind, message, letter.received_s, letter.is_retained)
        match message:
            case up.Telemetry():
                # ten times a second a robot, and looked at far less: made only when somebody looks
                self._store.put_telemetry(address.robot, partial(translate.telemetry, message, stamp))
            case up.Heartbeat():
                self._heartbeat(clock, message, stamp)
            case up.Safety():
                value = translate.safety(message, stamp, self._to_console(clock, message, stamp))
                self._store.put_safety(address.robot, value)
                self._tell(self.listeners.on_safety, address.robot, value)
            case up.State():
                value_s = translate.state(message, stamp, self._to_console(clock, message, stamp))
                self._store.put_state(address.robot, value_s)
            case up.Factsheet():
                self._store.put_factsheet(address.robot, translate.factsheet(message))
            case up.Presence():
                is_shutdown = message.reason == "shutdown"
                self._store.put_presence(
                    address.robot, is_online=message.online, is_shutdown=is_shutdown, received_s=stamp.received_s
                )
            case up.Node():
                to_console_s = self._to_console(clock, message, stamp)
                self._store.put_node(address.robot, translate.node(message, stamp, to_console_s))
            case machine.Body():
                self._store.put_body(address.robot, partial(translate_machine.body, message, stamp))
            case machine.Detections():
                self._store.put_sight(address.robot, translate_machine.sight(message, stamp))
            case machine.Worksite():
                self._store.put_worksite(address.robot, translate_machine.worksite(message, stamp))
            case _:
                self._happened(address, clock, message, stamp)

    def _clock_of(self, robot: str) -> RobotClock:
        if len(self._clocks) > 2 * len(self._store.registered_ids()) + 400:
            known = {r.id for r in self._store.robots()}
            self._clocks = {i: c for i, c in self._clocks.items() if i in known}
        return self._clocks.setdefault(robot, RobotClock())

    def _happened(self, address: Address, clock: RobotClock, message: up.Header, stamp: Stamp) -> None:
        if self._store.registration(address.robot) is None:
            self.tally.count("unregistered", address.robot)
        elif isinstance(message, up.Ack):
            self._tell(self.listeners.on_ack, translate.acknowledgement(message, stamp))
        elif isinstance(message, up.Event) and clock.is_repeated(message.event_id):
            self.tally.count("repeated", address.robot)
        elif isinstance(message, up.Event):
            age_s = max(0.0, self._clock.mono_s() - stamp.source_s)
            at = self._clock.utc() - timedelta(seconds=age_s)
            self._tell(self.listeners.on_event, translate.event(message, stamp, at))

    def _heartbeat(self, clock: RobotClock, message: up.Heartbeat, stamp: Stamp) -> None:
        assert self._pinger is not None
        if message.echo_nonce is not None:
            trip_s = self._pinger.answered(message.robot, message.echo_nonce, stamp.received_s)
            if trip_s is not None:
                stamp = clock.confirm(message, stamp.received_s, trip_s)
                self._store.put_round_trip(message.robot, max(0.0, trip_s - message.echo_held_ms / 1000))
        made_at = self._clock.utc().timestamp() - (self._clock.mono_s() - stamp.source_s)
        self._store.put_heartbeat(
            message.robot,
            boot=message.boot,
            challenge=message.challenge,
            heard_s=stamp.source_s,
            received_s=stamp.received_s,
            wall_offset_s=message.wall_ms / 1000 - made_at if message.wall_ms else None,
        )

    def _to_console(self, clock: RobotClock, message: up.Header, stamp: Stamp) -> Callable[[int], float]:
        return lambda mono_ms: clock.console_s(message.boot, mono_ms, stamp.source_s)

    def _link_changed(self, state: LinkState, text: str) -> None:
        if text != self.broker_text:
            log.info("broker %s: %s", state, text)
        self.broker_text = text
        self._store.set_broker(is_up=state is LinkState.UP)

    def _thread_fault(self, error: Exception) -> None:
        self.tally.count("thread_fault", text=repr(error))

    async def _watch(self) -> None:
        while True:
            await asyncio.sleep(WATCH_S)
            try:
                self.look_after()
            except Exception:  # who does not look any more never says that a robot is silent
                log.exception("looking after the links failed; it comes round again")

    def look_after(self) -> None:
        """Judge silence and revive a dead network thread; called twice a second."""
        self._store.refresh_links()
        self.arrivals.settle(self._store.registered_ids())
        if self._link is not None and not self._link.is_alive:
            self.tally.count("thread_died")
            self._tell(self.listeners.on_trouble, "ingest_thread", "The network thread had died and was started again.")
            self._link.start()

    async def _ping(self) -> None:
        while True:
            await asyncio.sleep(PING_SLOT_S)
            try:
                self.ping_due()
            except Exception:  # without a round trip nobody may drive
                log.exception("a round of pings failed; the next one comes")

    def ping_due(self) -> None:
        """Ping the robots whose second is over; called every 50 ms."""
        if self._pinger is not None:
            self._pinger.ping_due(self._store.registered_ids())

    def _tell(self, listeners: Sequence[Callable[..., None]], *values: object) -> None:
        for listener in list(listeners):
            try:
                listener(*values)
            except Exception:  # a listener's fault is not the robot's
                log.exception("a listener failed on %r", values[:1])
