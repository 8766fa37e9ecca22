"""One robot on the broker: what it publishes and when, and what it hears.

Lives on the event loop; paho's thread hands over by ``call_soon_threadsafe`` only.
"""

from __future__ import annotations

import asyncio
import math
import random
from collections import Counter, deque
from collections.abc import Callable
from dataclasses import dataclass

from msgspec.structs import replace

from backend_clients.edge import codec
from backend_clients.edge import messages_down as down
from backend_clients.edge import messages_up as up
from backend_clients.edge.fields import HEADER_IDS
from backend_clients.edge.mqtt import LinkState, Will
from backend_clients.edge.topics import Down, Up, parse, topic
from backend_clients.errors import MalformedPayload, WireError
from backend_clients.simulator.faults import fate
from backend_clients.simulator.inside import is_body_moving
from backend_clients.simulator.links import LinkMaker, RobotLink
from backend_clients.simulator.loop_mail import LoopMail
from backend_clients.simulator.unreadable_stop import read_anyway
from backend_clients.simulator.world import Boot, SimRobot

TICK_S = 0.05


@dataclass(frozen=True, slots=True)
class Rates:
    """How many ticks of the session pass between two messages of a kind."""

    heartbeat: int = 4  # 5 Hz at 20 ticks a second
    telemetry: int = 2  # 10 Hz
    state: int = 10  # 2 Hz
    safety: int = 4  # 5 Hz
    safety_stopping: int = 2  # 10 Hz
    nodes: int = 100  # each 5 s
    body: int = 2  # 10 Hz while joints move
    body_resting: int = 10  # 2 Hz
    scan: int = 20  # 1 Hz
    scan_far: int = 40  # of machines nobody works beside


LEAN = Rates(heartbeat=1, telemetry=1, state=1, safety=1, safety_stopping=1, nodes=60)
"""At 2 ticks a second: 2 Hz each, the slowest that no screen calls late."""
MAX_OUTBOX = 2000
SIGHTS_S = 0.5
NODES_MS, LEAN_NODES_MS = 5_000, 30_000  # the rates above, at 20 and 2 ticks a second
OUTBOX_PER_TICK = 50  # after an outage, without drowning what is live


class EdgeSession:
    """Publishes one robot's messages and feeds it what comes down.

    Args:
        robot: the simulated machine.
        make_link: gives it a connection at each boot.
        loop: where everything but paho's own thread runs.
        mail: the way from that thread to the loop, shared by the robots of a process.
    """

    def __init__(
        self, robot: SimRobot, make_link: LinkMaker, loop: asyncio.AbstractEventLoop, mail: LoopMail | None = None
    ) -> None:
        self._robot, self._make_link, self._loop = robot, make_link, loop
        self._mail = mail or LoopMail(loop)
        self._rates = LEAN if robot.config.is_lean else Rates()
        self._boot: Boot | None = None
        self._link: RobotLink | None = None
        self._tick = 0
        self._outbox: deque[up.Event] = deque(maxlen=MAX_OUTBOX)
        self._rng = random.Random(f"network/{robot.config.id}")  # noqa: S311
        self._shown: dict[Up, object] = {}
        self._sent = Counter[Up]()  # of this boot
        self._told_sights: dict[str, float] = {}
        self.unreadable = 0

    @property
    def is_lean(self) -> bool:
        """Whether it ticks at 2 Hz."""
        return self._robot.config.is_lean

    @property
    def is_up(self) -> bool:
        """Whether the broker connection stands."""
        return self._link is not None and self._link.is_up

    def tick(self) -> None:
        """Publish what is due; called at 20 Hz after the world's step, for a lean robot at 2 Hz."""
        if self._robot.boot is not self._boot:
            self._follow_boot()
        boot = self._boot
        if boot is None:
            return
        self._tick += 1
        self._collect_events(boot)
        if not self.is_up:
            return
        if self._tick % self._rates.heartbeat == 0 or boot.reporter.is_ping_waiting:
            self._say(Up.HEARTBEAT, boot.reporter.heartbeat())
        if self._tick % self._rates.telemetry == 0:
            self._say(Up.TELEMETRY, boot.reporter.telemetry())
        self._report_safety(boot)
        self._report_state(boot)
        if self._tick % self._rates.nodes == 0 or self._shown.get(Up.NODE) != boot.brain.nodes.revision:
            self._report_nodes(boot)
        if not self.is_lean:
            self._report_inside(boot)
        if self._robot.sights:
            self._report_sights(boot)
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
            goodbye = self._numbered(Up.PRESENCE, self._boot.reporter.goodbye("shutdown"))
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
        self._sent.clear()
        if self._boot is None:
            return
        robot_id = self._robot.config.id
        will = Will(topic(robot_id, Up.PRESENCE), codec.encode(self._boot.reporter.goodbye("lost")))
        client_id = f"robot-{robot_id}-{self._boot.brain.boot[:8]}"
        self._link = self._make_link(robot_id, client_id, self._on_message, self._on_link(self._boot), will)
        self._link.start()

    def _on_link(self, boot: Boot) -> Callable[[LinkState, str], None]:
        def changed(state: LinkState, _text: str) -> None:
            if state is LinkState.UP:
                self._mail.post(lambda: self._greet(boot))

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
        if not self.is_lean:
            self._report_inside(boot)

    # ---- up -----------------------------------------------------------------------------------------

    def _report_safety(self, boot: Boot) -> None:
        brain = boot.brain
        is_stopping = brain.is_stopped and not brain.machine.is_standing
        due = self._tick % (self._rates.safety_stopping if is_stopping else self._rates.safety) == 0
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
            brain.watch.activity.states if brain.watch.activity is not None else None,
            brain.hold_code,
            brain.guard.active_lease,
            (run.sha256, run.status, run.row, run.pause_code) if run is not None else None,
        )
        is_new = self._shown.get(Up.STATE) != shown
        if is_new or self._tick % self._rates.state == 0:
            self._shown[Up.STATE] = shown
            self._say(Up.STATE, boot.reporter.state(), qos=1 if is_new or not self.is_lean else 0)

    def _report_inside(self, boot: Boot) -> None:
        machine = boot.brain.machine
        every = self._rates.body if is_body_moving(machine) else self._rates.body_resting
        if self._tick % every == 0:
            self._say(Up.BODY, boot.reporter.body())
        rig = machine.rig
        shown = (rig.site.stop, rig.site.revision) if rig is not None and rig.site is not None else None
        if shown is not None and self._shown.get(Up.WORKSITE) != shown:
            site = boot.reporter.worksite()
            if site is not None:
                self._shown[Up.WORKSITE] = shown
                self._say(Up.WORKSITE, site, qos=1, retain=True)
        if self._tick % (self._rates.scan_far if rig is None else self._rates.scan) == 0:
            self._say(Up.SCAN, boot.reporter.scan())

    def _report_sights(self, boot: Boot) -> None:
        """Say what was found in pictures that somebody pulls: one camera a tick, each at most twice a second."""
        now_s = boot.brain.clock.mono_s()
        for sight in self._robot.sights.values():
            told_s = self._told_sights.get(sight.camera, -math.inf)
            if sight.is_fresh(now_s) and sight.taken_s > told_s and now_s - told_s >= SIGHTS_S:
                self._told_sights[sight.camera] = now_s
                self._say(Up.DETECTIONS, boot.reporter.detections(sight))
                return

    def _report_nodes(self, boot: Boot) -> None:
        self._shown[Up.NODE] = boot.brain.nodes.revision
        for node in boot.reporter.nodes(LEAN_NODES_MS if self.is_lean else NODES_MS):
            self._say(Up.NODE, node, qos=1, retain=True)

    def _collect_events(self, boot: Boot) -> None:
        self._outbox.extend(boot.reporter.event(happening) for happening in self._robot.take_events())

    def _empty_outbox(self) -> None:
        if self._robot.faults.silence is not None:
            return
        for _ in range(min(OUTBOX_PER_TICK, len(self._outbox))):
            if not self._send(Up.EVENT, self._numbered(Up.EVENT, self._outbox[0]), qos=1, retain=False):
                self._sent[Up.EVENT] -= 1  # it has not left
                return
            self._outbox.popleft()

    def _say(self, kind: Up, message: up.Header, *, qos: int = 0, retain: bool = False) -> None:
        if self._robot.faults.silence is not None:
            return
        payload = self._numbered(kind, message)
        for delay_s in fate(self._robot.faults.packets, "up", self._rng):
            if delay_s > 0:
                self._loop.call_later(delay_s, self._send, kind, payload, qos, retain)
            else:
                self._send(kind, payload, qos, retain)

    def _numbered(self, kind: Up, message: up.Header) -> bytes:
        """Return a message as it is sent, with its number among those of its kind; HTTP answers have none."""
        self._sent[kind] += 1
        return codec.encode(replace(message, header_id=(self._sent[kind] - 1) % HEADER_IDS))

    def _send(self, kind: Up, payload: bytes, qos: int, retain: bool) -> bool:
        link = self._link
        return link is not None and link.publish(topic(self._robot.config.id, kind), payload, qos=qos, retain=retain)

    # ---- down ---------------------------------------------------------------------------------------

    def _on_message(self, name: str, payload: bytes, is_retained: bool) -> None:
        self._mail.post(lambda: self._arrived(name, payload, is_retained))

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


def _as_order(message: up.Header | down.Order) -> down.Order | None:
    return message if isinstance(message, down.Order) else None
