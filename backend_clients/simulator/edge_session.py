"""One robot on the broker: what it publishes and when, and what it hears.

Lives on the event loop; paho's thread hands over by ``call_soon_threadsafe`` only.
"""

from __future__ import annotations

import asyncio
import random
from collections import deque
from collections.abc import Callable

from backend_clients.edge import codec
from backend_clients.edge import messages_down as down
from backend_clients.edge import messages_up as up
from backend_clients.edge.mqtt import LinkState, MqttLink, Will
from backend_clients.edge.topics import Down, Up, parse, topic
from backend_clients.errors import MalformedPayload, WireError
from backend_clients.simulator.faults import fate
from backend_clients.simulator.unreadable_stop import read_anyway
from backend_clients.simulator.world import Boot, SimRobot

TICK_S = 0.05
HEARTBEAT_TICKS = 4  # 5 Hz
TELEMETRY_TICKS = 2  # 10 Hz
STATE_TICKS = 10  # 2 Hz
SAFETY_TICKS, SAFETY_STOPPING_TICKS = 4, 2  # 5 Hz, 10 Hz while stopping
NODE_TICKS = 100  # each 5 s
MAX_OUTBOX = 2000
OUTBOX_PER_TICK = 50  # after an outage, without drowning what is live


class EdgeSession:
    """Publishes one robot's messages and feeds it what comes down.

    Args:
        robot: the simulated machine.
        broker_url: ``mqtt://host:port``.
        loop: where everything but paho's own thread runs.
    """

    def __init__(self, robot: SimRobot, broker_url: str, loop: asyncio.AbstractEventLoop) -> None:
        self._robot, self._broker_url, self._loop = robot, broker_url, loop
        self._boot: Boot | None = None
        self._link: MqttLink | None = None
        self._tick = 0
        self._outbox: deque[up.Event] = deque(maxlen=MAX_OUTBOX)
        self._rng = random.Random(f"network/{robot.config.id}")  # noqa: S311
        self._shown: dict[Up, object] = {}
        self.unreadable = 0

    @property
    def is_up(self) -> bool:
        """Whether the broker connection stands."""
        return self._link is not None and self._link.is_up

    def tick(self) -> None:
        """Publish what is due; called at 20 Hz after the world's step."""
        if self._robot.boot is not self._boot:
            self._follow_boot()
        boot = self._boot
        if boot is None:
            return
        self._tick += 1
        self._collect_events(boot)
        if not self.is_up:
            return
        if self._tick % HEARTBEAT_TICKS == 0 or boot.reporter.is_ping_waiting:
            self._say(Up.HEARTBEAT, boot.reporter.heartbeat())
        if self._tick % TELEMETRY_TICKS == 0:
            self._say(Up.TELEMETRY, boot.reporter.telemetry())
        self._report_safety(boot)
        self._report_state(boot)
        if self._tick % NODE_TICKS == 0:
            self._report_nodes(boot)
        self._empty_outbox()

    def close(self, *, is_abrupt: bool = False) -> None:
        """Leave the broker: with a goodbye, or as if the power went off."""
        link, self._link = self._link, None
        if link is None:
            return
        if is_abrupt:
            link.drop()
            return
        if self._boot is not None and link.is_up:
            goodbye = codec.encode(self._boot.reporter.goodbye("shutdown"))
            link.publish(topic(self._robot.config.id, Up.PRESENCE), goodbye, qos=1, retain=True)
        link.stop()

    def answer(self, ack: up.Ack | None) -> None:
        """Publish an acknowledgement and what changed with it."""
        if ack is None or self._boot is None:
            return
        self._say(Up.ACK, ack, qos=1)
        self._report_safety(self._boot)
        self._report_state(self._boot)

    # ---- boot and connection ----------------------------------------------------------------------

    def _follow_boot(self) -> None:
        self.close(is_abrupt=self._boot is not None)
        self._boot = self._robot.boot
        self._shown.clear()
        if self._boot is None:
            return
        robot_id = self._robot.config.id
        will = Will(topic(robot_id, Up.PRESENCE), codec.encode(self._boot.reporter.goodbye("lost")))
        self._link = MqttLink(
            self._broker_url,
            f"robot-{robot_id}-{self._boot.brain.boot[:8]}",
            subscriptions=[(topic(robot_id, kind), 0 if kind in _FAST else 1) for kind in Down],
            on_message=self._on_message,
            on_link=self._on_link(self._boot),
            will=will,
        )
        self._link.start()

    def _on_link(self, boot: Boot) -> Callable[[LinkState, str], None]:
        def changed(state: LinkState, _text: str) -> None:
            if state is LinkState.UP:
                self._call(lambda: self._greet(boot))

        return changed

    def _greet(self, boot: Boot) -> None:
        if boot is not self._boot:
            return
        self._shown.clear()
        self._say(Up.PRESENCE, boot.reporter.presence(), qos=1, retain=True)
        self._say(Up.FACTSHEET, boot.reporter.factsheet(), qos=1, retain=True)
        self._say(Up.HEARTBEAT, boot.reporter.heartbeat())
        self._report_safety(boot)
        self._report_state(boot)
        self._report_nodes(boot)

    # ---- up -----------------------------------------------------------------------------------------

    def _report_safety(self, boot: Boot) -> None:
        brain = boot.brain
        is_stopping = brain.is_stopped and not brain.machine.is_standing
        due = self._tick % (SAFETY_STOPPING_TICKS if is_stopping else SAFETY_TICKS) == 0
        machine = brain.machine
        shown = (
            brain.latch.is_set,
            machine.is_hardware_stop,
            machine.is_standing,
            machine.tool_on,
            tuple((press.stop_id, press.is_reset) for press in brain.latch.presses),
        )
        is_new = self._shown.get(Up.SAFETY) != shown
        if is_new or due:
            self._shown[Up.SAFETY] = shown
            self._say(Up.SAFETY, boot.reporter.safety(), qos=1 if is_new else 0)

    def _report_state(self, boot: Boot) -> None:
        brain = boot.brain
        run = brain.run
        shown = (
            brain.mode,
            brain.watch.path,
            brain.watch.faults,
            brain.hold_code,
            brain.guard.active_lease,
            (run.sha256, run.status, run.row, run.pause_code) if run is not None else None,
        )
        if self._shown.get(Up.STATE) != shown or self._tick % STATE_TICKS == 0:
            self._shown[Up.STATE] = shown
            self._say(Up.STATE, boot.reporter.state(), qos=1)

    def _report_nodes(self, boot: Boot) -> None:
        for node in boot.reporter.nodes():
            self._say(Up.NODE, node, qos=1, retain=True)

    def _collect_events(self, boot: Boot) -> None:
        self._outbox.extend(boot.reporter.event(happening) for happening in self._robot.take_events())

    def _empty_outbox(self) -> None:
        if self._robot.faults.silence is not None:
            return
        for _ in range(min(OUTBOX_PER_TICK, len(self._outbox))):
            event = self._outbox[0]
            if not self._send(Up.EVENT, codec.encode(event), qos=1, retain=False):
                return
            self._outbox.popleft()

    def _say(self, kind: Up, message: up.Header, *, qos: int = 0, retain: bool = False) -> None:
        if self._robot.faults.silence is not None:
            return
        payload = codec.encode(message)
        for delay_s in fate(self._robot.faults.packets, "up", self._rng):
            if delay_s > 0:
                self._loop.call_later(delay_s, self._send, kind, payload, qos, retain)
            else:
                self._send(kind, payload, qos, retain)

    def _send(self, kind: Up, payload: bytes, qos: int, retain: bool) -> bool:
        link = self._link
        return link is not None and link.publish(topic(self._robot.config.id, kind), payload, qos=qos, retain=retain)

    # ---- down ---------------------------------------------------------------------------------------

    def _on_message(self, name: str, payload: bytes, is_retained: bool) -> None:
        self._call(lambda: self._arrived(name, payload, is_retained))

    def _arrived(self, name: str, payload: bytes, is_retained: bool) -> None:
        silence = self._robot.faults.silence
        if silence is not None and silence.deaf:
            return
        for delay_s in fate(self._robot.faults.packets, "down", self._rng):
            if delay_s > 0:
                self._loop.call_later(delay_s, self._hear, name, payload, is_retained)
            else:
                self._hear(name, payload, is_retained)

    def _hear(self, name: str, payload: bytes, is_retained: bool) -> None:
        order = self._read(name, payload)
        if order is not None:
            self.answer(self._robot.receive(order, is_retained=is_retained))

    def _read(self, name: str, payload: bytes) -> down.Order | None:
        try:
            address = parse(name)
            if address.robot != self._robot.config.id:
                return None
            return _as_order(codec.decode_body(address, payload))
        except MalformedPayload:
            self.unreadable += 1
            if address.kind is Down.STOP:  # what was meant as a STOP must stop, whatever else it says
                return read_anyway(self._robot.config.id, payload)
        except WireError:
            self.unreadable += 1
        return None

    def _call(self, work: Callable[[], None]) -> None:
        if not self._loop.is_closed():
            self._loop.call_soon_threadsafe(work)


_FAST = {Down.DRIVE, Down.OPERATOR, Down.PING}


def _as_order(message: up.Header | down.Order) -> down.Order | None:
    return message if isinstance(message, down.Order) else None
