"""The console's own connection for field stations: from raw payloads to the board.

It is not the robots' connection: a picture of half a megabyte must never wait before what a safety controller says.
The network thread only puts payloads into a bounded box; nothing a station sends ends it, and what is wrong is counted.
"""

from __future__ import annotations

import asyncio
import contextlib
import logging
import threading
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

from msgspec import UNSET

from backend_clients.edge.mqtt import LinkState, MqttLink, OnLink, OnMessage
from backend_clients.errors import MalformedPayload, OversizedPayload, WireError, WrongIdentity
from backend_clients.field import messages
from backend_clients.field.codec import decode_body, decode_frame, encode
from backend_clients.field.topics import Address, Down, Up, every_station, parse, topic
from hmi.clock import Clock
from hmi.domain.sensors.observation import SensorKind
from hmi.domain.sensors.order import NoticeOrder, TriggerOrder
from hmi.domain.sensors.quantity import Channel, is_unit_right
from hmi.domain.sensors.station import Announcement, Report, StationAnswer
from hmi.ingest.coordinator import BrokerLink, OnFault
from hmi.ingest.tally import Tally

log = logging.getLogger(__name__)
WORDS_LIMIT = 5_000  # some 25 MB at worst; a farm of 50 stations sends one a second
FRAMES_LIMIT = 16  # newest of each camera, half a megabyte each
WATCH_S = 5.0
CADENCE_S = 0.2
SUBSCRIPTIONS = [(every_station(kind), 0 if kind is Up.FRAME else 1) for kind in Up]
_REASONS: dict[type[WireError], str] = {
    MalformedPayload: "malformed",
    OversizedPayload: "oversized",
    WrongIdentity: "wrong_identity",
}
MakeLink = Callable[[OnMessage, OnLink, OnFault], BrokerLink]


def field_link(url: str, client_id: str, *, ca_file: str | None = None) -> MakeLink:
    """Return what makes the real connection, subscribed to everything stations say."""

    def make(on_message: OnMessage, on_link: OnLink, on_fault: OnFault) -> BrokerLink:
        return MqttLink(
            url, client_id, subscriptions=SUBSCRIPTIONS, on_message=on_message, on_link=on_link, on_fault=on_fault,
            ca_file=ca_file,
        )  # fmt: skip

    return make


class Letter(NamedTuple):
    """One raw message and when the network thread had it, in monotonic seconds."""

    address: Address
    payload: bytes
    received_s: float
    is_retained: bool


class FieldBox:
    """Between the network thread and the event loop, in bounded memory; of pictures only the newest waits."""

    def __init__(self, call: Callable[[], None], mono_s: Callable[[], float]) -> None:
        self._call, self._mono_s = call, mono_s
        self._lock = threading.Lock()
        self._words: deque[Letter] = deque()
        self._frames: dict[str, Letter] = {}
        self._lost: dict[str, int] = {}
        self._is_called = False

    def post(self, text: str, payload: bytes, is_retained: bool) -> None:
        """Take one message; any thread, any bytes, never raises for what is in them."""
        received_s = self._mono_s()
        try:
            address = parse(text)
            if isinstance(address.kind, Down):
                raise WrongIdentity(f"{text} is a topic of the console")
        except WireError:
            self._count("bad_topic")
            return
        with self._lock:
            self._keep(Letter(address, payload, received_s, is_retained))
            is_first, self._is_called = not self._is_called, True
        if is_first:
            self._call()

    def take(self) -> tuple[list[Letter], dict[str, int]]:
        """Empty the box: what came, and what was lost by reason."""
        with self._lock:
            found, lost = [*self._words, *self._frames.values()], self._lost
            self._words.clear()
            self._frames.clear()
            self._lost, self._is_called = {}, False
        return found, lost

    def _keep(self, letter: Letter) -> None:
        if letter.address.kind is not Up.FRAME:
            if len(self._words) >= WORDS_LIMIT:
                self._words.popleft()
                self._lost["overflow"] = self._lost.get("overflow", 0) + 1
            self._words.append(letter)
        elif letter.address.station in self._frames or len(self._frames) < FRAMES_LIMIT:
            self._frames[letter.address.station] = letter
        else:
            self._lost["too_many_frames"] = self._lost.get("too_many_frames", 0) + 1

    def _count(self, reason: str) -> None:
        with self._lock:
            self._lost[reason] = self._lost.get(reason, 0) + 1


@dataclass(slots=True)
class FieldListeners:
    """Who takes what stations say, each called on the loop.

    Args:
        announced, gone: what a station says about itself, and that it took it back.
        reported: values, with when they arrived on the monotonic clock.
        pictured: a JPEG picture.
        answered: an answer to a notice or trigger.
        linked: whether the broker is there now.
    """

    announced: Callable[[Announcement], None]
    gone: Callable[[str], None]
    reported: Callable[[Report, float], None]
    pictured: Callable[[str, bytes], None]
    answered: Callable[[StationAnswer], None]
    linked: Callable[[bool], None]


class FieldCoordinator:
    """Receives all stations of one broker and speaks to them.

    Args:
        make_link: see ``field_link``.
    """

    def __init__(self, make_link: MakeLink, clock: Clock, listeners: FieldListeners) -> None:
        self._make_link, self._clock, self._listeners = make_link, clock, listeners
        self._link: BrokerLink | None = None
        self._box: FieldBox | None = None
        self._task: asyncio.Task[None] | None = None
        self._drained_s = float("-inf")
        self.tally = Tally()
        self.messages = 0
        self.broker_text = "not started"

    @property
    def is_up(self) -> bool:
        """Whether what is sent now would leave."""
        return self._link is not None and self._link.is_up

    async def start(self) -> None:
        """Connect in the background; the running loop becomes the home of everything here."""
        loop = asyncio.get_running_loop()

        def soon(work: Callable[..., None], *values: object) -> None:
            with contextlib.suppress(RuntimeError):  # the loop has ended
                loop.call_soon_threadsafe(work, *values)

        self._box = FieldBox(lambda: soon(self._mail), self._clock.mono_s)
        self._link = self._make_link(
            self._box.post,
            lambda state, text: soon(self._linked, state, text),
            lambda error: soon(self._fault, error),
        )
        self._link.start()
        self._task = asyncio.create_task(self._watch(), name="field-watch")

    async def stop(self) -> None:
        """Disconnect; returns when the network thread has ended."""
        if self._task is not None:
            self._task.cancel()
            await asyncio.gather(self._task, return_exceptions=True)
        if self._link is not None:
            await asyncio.to_thread(self._link.stop)
            self._link = None

    def send(self, order: NoticeOrder | TriggerOrder) -> bool:
        """Send now or not at all; a notice is retained."""
        if isinstance(order, NoticeOrder):
            return self._publish(topic(order.station_id, Down.NOTICE), encode(_notice(order)), retain=True)
        return self._publish(topic(order.station_id, Down.TRIGGER), encode(_trigger(order)), retain=False)

    def clear_notice(self, station_id: str) -> bool:
        """Take the retained notice of a station away."""
        return self._publish(topic(station_id, Down.NOTICE), b"", retain=True)

    def drain(self) -> None:
        """Open what is in the box now; called by itself, and by tests that do not wait."""
        if self._box is None:
            return
        letters, lost = self._box.take()
        self._drained_s = self._clock.mono_s()
        for reason, number in lost.items():
            self.tally.count(reason, number=number)
        for letter in letters:
            self._open(letter)

    def diagnostics(self) -> dict[str, Any]:
        """Return counters for the diagnostics page."""
        return {
            "broker": "up" if self.is_up else "down",
            "broker_text": self.broker_text,
            "messages": self.messages,
            "refused": dict(self.tally.total),
            "refused_by_station": self.tally.by_robot(),
            "examples": dict(self.tally.last_text),
        }

    def look_after(self) -> None:
        """Revive a dead network thread."""
        if self._link is not None and not self._link.is_alive:
            self.tally.count("thread_died")
            self._link.start()

    def _publish(self, name: str, payload: bytes, *, retain: bool) -> bool:
        return self._link is not None and self._link.publish(name, payload, qos=1, retain=retain)

    def _mail(self) -> None:
        wait_s = self._drained_s + CADENCE_S - self._clock.mono_s()
        if wait_s <= 0:
            self.drain()
        else:
            asyncio.get_running_loop().call_later(wait_s, self.drain)

    def _open(self, letter: Letter) -> None:
        station = letter.address.station
        self.messages += 1
        try:
            self._apply(letter)
        except WireError as error:
            self.tally.count(_REASONS.get(type(error), "malformed"), station, str(error))
        except Exception:  # one bad station must not silence the others
            log.exception("applying %s of %s failed", letter.address.kind, station)
            self.tally.count("internal_error", station)

    def _apply(self, letter: Letter) -> None:
        address, tell = letter.address, self._listeners
        if address.kind is Up.FRAME:
            if letter.is_retained:
                self.tally.count("retained", address.station)  # a picture of who knows when
                return
            tell.pictured(address.station, decode_frame(address, letter.payload))
            return
        if address.kind is Up.ABOUT and not letter.payload:
            tell.gone(address.station)
            return
        message = decode_body(address, letter.payload)
        match message:
            case messages.About():
                tell.announced(self._announcement(message))
            case messages.Data() if letter.is_retained:
                self.tally.count("retained", address.station)
            case messages.Data():
                tell.reported(_report(message), letter.received_s)
            case messages.Ack():
                answer = StationAnswer(message.station, message.id, message.outcome == "accepted", message.text)
                tell.answered(answer)

    def _announcement(self, said: messages.About) -> Announcement:
        units = {}
        for one in said.quantities:
            if not is_unit_right(one.quantity, one.unit):
                self.tally.count("wrong_unit", said.station, f"{one.quantity} in {one.unit}")
                continue
            units[Channel.of(one.quantity, None if one.depth_m is UNSET else one.depth_m)] = one.unit
        parcel = "" if said.parcel is UNSET else said.parcel
        return Announcement(
            said.station, said.name, SensorKind(said.kind), said.lat_deg, said.lon_deg, said.period_s, units,
            said.model, parcel,
        )  # fmt: skip

    def _linked(self, state: LinkState, text: str) -> None:
        self.broker_text = text
        self._listeners.linked(state is LinkState.UP)

    def _fault(self, error: Exception) -> None:
        self.tally.count("thread_fault", text=repr(error))

    async def _watch(self) -> None:
        while True:
            await asyncio.sleep(WATCH_S)
            try:
                self.look_after()
            except Exception:  # a thread that cannot be started now may be a moment later
                log.exception("looking after the connection to the stations failed; it comes round again")


def _report(said: messages.Data) -> Report:
    values = tuple(
        (Channel.of(one.quantity, None if one.depth_m is UNSET else one.depth_m), one.value) for one in said.values
    )
    battery = None if said.battery is UNSET else said.battery
    mono_s = None if said.mono_ms is UNSET else said.mono_ms / 1000
    return Report(said.station, said.boot, said.seq, said.utc, values, battery, mono_s)


def _notice(order: NoticeOrder) -> messages.Notice:
    return messages.Notice(
        station=order.station_id,
        id=order.ref,
        utc=order.at,
        is_treating=order.is_treating,
        robots=list(order.robots),
        parcel=order.parcel,
        until_utc=order.until,
    )


def _trigger(order: TriggerOrder) -> messages.Trigger:
    return messages.Trigger(station=order.station_id, id=order.ref, utc=order.at, ttl_s=order.ttl_s)
