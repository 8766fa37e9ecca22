"""The newest known state of every robot, with a revision that tells who changed since when.

Lives on the event loop; nothing here blocks or waits. Values are replaced as a whole, so that a ``Robot``
once read never changes.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterable
from typing import NamedTuple

from hmi.domain import robot as domain
from hmi.domain.machine import Body, Sight, Worksite
from hmi.store.robot_record import RETAINED_PARTS, Part, Registered, RobotRecord

UNREGISTERED_LIMIT = 200  # robots heard but not in the registry; more would let a hostile wire fill memory
UNREGISTERED_KEPT_S = 60.0  # one that was silent this long makes room for a new one
NODE_LIMIT = 64  # software nodes a robot may report
CAMERA_LIMIT = 16  # cameras of a robot whose sights are kept
RTT_WINDOW_S = 60.0
REMOVED_KEPT = 1000
log = logging.getLogger(__name__)


class RobotAddress(NamedTuple):
    """Where a robot's HTTP endpoint is, from the registry alone."""

    http_url: str
    token: str


class Changes(NamedTuple):
    """What changed after a revision; ``revision`` is what to ask with next time."""

    revision: int
    robots: dict[str, frozenset[Part]]
    removed: frozenset[str]


class Beat(NamedTuple):
    """When a robot's newest heartbeat was true, and its round trip."""

    robot_id: str
    heard_s: float | None
    rtt_s: float | None


class FleetStore:
    """Live state of all robots of one console.

    Args:
        mono_s: the console's monotonic clock.
        farm_id: farm that unregistered robots are shown to.
    """

    def __init__(self, mono_s: Callable[[], float], farm_id: str = "farm") -> None:
        self._mono_s, self._farm_id = mono_s, farm_id
        self._records: dict[str, RobotRecord] = {}
        self._registered: tuple[str, ...] = ()
        self._changed: dict[str, int] = {}  # robot -> newest revision, in order of change
        self._removed: dict[str, int] = {}
        # the broker tells retained messages only to who connects: a robot that was taken out may come back before that
        self._left: dict[str, RobotRecord] = {}
        self._is_broker_up = False
        self._listeners: list[Callable[[], None]] = []
        self.revision = 0

    def robot(self, robot_id: str) -> domain.Robot | None:
        """Return one robot as it is known now."""
        record = self._records.get(robot_id)
        return None if record is None else record.robot(self._farm_id, is_broker_up=self._is_broker_up)

    def robots(self) -> list[domain.Robot]:
        """Return every robot, registered ones first, by id."""
        records = sorted(self._records.values(), key=lambda r: (r.entry is None, r.id))
        return [r.robot(self._farm_id, is_broker_up=self._is_broker_up) for r in records]

    def registration(self, robot_id: str) -> Registered | None:
        """Return the registry entry; ``None`` for a robot that is only heard."""
        record = self._records.get(robot_id)
        return None if record is None else record.entry

    def is_online(self, robot_id: str) -> bool:
        """Say whether a robot is heard, without building it."""
        record = self._records.get(robot_id)
        return record is not None and record.is_online

    def was_heard(self, robot_id: str) -> bool:
        """Say whether a robot was heard since the start, without building it."""
        record = self._records.get(robot_id)
        return record is not None and record.heard_s is not None

    def said_goodbye(self, robot_id: str) -> bool:
        """Say whether a robot told that it was shut down, without building it."""
        record = self._records.get(robot_id)
        return record is not None and record.said_goodbye

    def registered_ids(self) -> tuple[str, ...]:
        """Return the ids of the registry."""
        return self._registered

    def address(self, robot_id: str) -> RobotAddress | None:
        """Return where the robot's HTTP is; from the registry, never from the wire."""
        entry = self.registration(robot_id)
        if entry is None or not entry.http_url:
            return None
        return RobotAddress(entry.http_url, entry.http_token or "")

    def since(self, revision: int) -> Changes:
        """Return which parts of which robots changed after ``revision``."""
        robots: dict[str, frozenset[Part]] = {}
        for robot_id in reversed(self._changed):
            if self._changed[robot_id] <= revision:
                break
            parts = self._records[robot_id].revisions
            robots[robot_id] = frozenset(p for p, r in parts.items() if r > revision)
        removed = frozenset(i for i, r in self._removed.items() if r > revision)
        return Changes(self.revision, robots, removed)

    def moved_since(self, revision: int) -> list[tuple[str, domain.Pose]]:
        """Return where the robots are whose telemetry changed after ``revision``; cheap for a thousand of them."""
        moved = []
        for robot_id in reversed(self._changed):
            if self._changed[robot_id] <= revision:
                break
            record = self._records[robot_id]
            if record.revisions.get(Part.TELEMETRY, 0) > revision:
                moved.append((robot_id, record.fast().pose))
        return moved

    def places(self) -> list[tuple[str, domain.Pose]]:
        """Return where every robot was last, silent ones too."""
        return [(r.id, r.fast().pose) for r in self._records.values() if r.telemetry is not None]

    def beats_since(self, revision: int) -> list[Beat]:
        """Return when the robots were heard whose link changed after ``revision``; cheap for a thousand of them."""
        beats = []
        for robot_id in reversed(self._changed):
            if self._changed[robot_id] <= revision:
                break
            record = self._records[robot_id]
            if record.revisions.get(Part.LINK, 0) > revision:
                beats.append(Beat(robot_id, record.heard_s, record.rtt_s))
        return beats

    def beats(self) -> list[Beat]:
        """Return when every robot was heard last."""
        return [Beat(r.id, r.heard_s, r.rtt_s) for r in self._records.values()]

    def subscribe(self, listener: Callable[[], None]) -> Callable[[], None]:
        """Call ``listener`` after each batch of changes; returns what ends it."""
        self._listeners.append(listener)
        return lambda: self._listeners.remove(listener)

    def announce(self) -> None:
        """Tell the listeners that a batch of changes is complete; what one raises is logged and harms no other."""
        for listener in list(self._listeners):
            try:
                listener()
            except Exception:  # a listener's fault is no robot's
                log.exception("a listener of the fleet failed")

    def set_registry(self, entries: Iterable[Registered]) -> None:
        """Take over the registry: names, addresses, who may be operated."""
        by_id = {e.id: e for e in entries}
        self._registered = tuple(by_id)
        for robot_id in [r.id for r in self._records.values() if r.entry is not None and r.id not in by_id]:
            self._left[robot_id] = self._records[robot_id].retained()
            if len(self._left) > REMOVED_KEPT:
                del self._left[next(iter(self._left))]
            self._drop(robot_id)
        for robot_id, entry in by_id.items():
            record = self._records.get(robot_id) or self._add(robot_id)
            if record.entry is not entry:
                record.entry = entry
                self._touch(record, Part.REGISTRY)
        self.announce()

    def admit(self, robot_id: str) -> bool:
        """Make room for a robot that was heard; ``False`` if it is unknown and there are too many such.

        One that was registered before always gets in, so that what it keeps at the broker is never missed.
        """
        if robot_id in self._records:
            return True
        strangers = [r for r in self._records.values() if r.entry is None]
        if len(strangers) >= UNREGISTERED_LIMIT and robot_id not in self._left:
            oldest = min(strangers, key=lambda r: r.active_s)
            if self._mono_s() - oldest.active_s < UNREGISTERED_KEPT_S:
                return False
            self._drop(oldest.id)
        self._touch(self._add(robot_id), Part.REGISTRY)
        return True

    def put_factsheet(self, robot_id: str, value: domain.Factsheet) -> None:
        """Replace what the robot says it is."""
        record = self._records[robot_id]
        if record.factsheet != value:
            record.factsheet = value
            self._touch(record, Part.FACTSHEET)

    def put_telemetry(self, robot_id: str, value: domain.Telemetry | Callable[[], domain.Telemetry]) -> None:
        """Replace the fast values; a function is asked for them when somebody looks."""
        record = self._records[robot_id]
        record.telemetry = value
        self._touch(record, Part.TELEMETRY)

    def put_state(self, robot_id: str, value: domain.RobotState) -> None:
        """Replace the operating state."""
        record = self._records[robot_id]
        record.state = value
        self._touch(record, Part.STATE)

    def put_safety(self, robot_id: str, value: domain.SafetyState) -> None:
        """Replace the safety state."""
        record = self._records[robot_id]
        record.safety = value
        self._touch(record, Part.SAFETY)

    def put_node(self, robot_id: str, value: domain.Node) -> None:
        """Replace one software node; more than ``NODE_LIMIT`` names are ignored."""
        record = self._records[robot_id]
        if value.name in record.nodes or len(record.nodes) < NODE_LIMIT:
            record.nodes = {**record.nodes, value.name: value}
            self._touch(record, Part.NODES)

    def put_body(self, robot_id: str, value: Body | Callable[[], Body]) -> None:
        """Replace joints, gauges and sightings; a function is asked for them when somebody looks."""
        record = self._records[robot_id]
        record.body = value
        self._touch(record, Part.BODY)

    def put_sight(self, robot_id: str, value: Sight) -> None:
        """Replace what was found in one camera's picture; more than ``CAMERA_LIMIT`` cameras are ignored."""
        record = self._records[robot_id]
        if value.camera in record.sights or len(record.sights) < CAMERA_LIMIT:
            record.sights = {**record.sights, value.camera: value}
            self._touch(record, Part.SIGHT)

    def put_worksite(self, robot_id: str, value: Worksite) -> None:
        """Replace where it works."""
        record = self._records[robot_id]
        record.worksite = value
        self._touch(record, Part.WORKSITE)

    def put_heartbeat(
        self,
        robot_id: str,
        *,
        boot: str,
        challenge: str,
        heard_s: float,
        received_s: float | None = None,
        wall_offset_s: float | None = None,
    ) -> None:
        """Take a heartbeat; ``heard_s`` is when it was made, so that a held one does not count as hearing.

        One that came before the robot left (``received_s``, by default now) and waited here does not bring it back.
        """
        record = self._records[robot_id]
        received_s = self._mono_s() if received_s is None else received_s
        record.wall_offset_s = wall_offset_s
        record.boot, record.challenge, record.heard_s = boot, challenge, heard_s
        record.active_s = self._mono_s()
        if received_s >= record.gone_s:
            record.is_gone = record.said_goodbye = False
        record.is_online = record.is_heard(self._mono_s())
        self._touch(record, Part.LINK)

    def put_round_trip(self, robot_id: str, rtt_s: float) -> None:
        """Take one measured round trip console - robot - console."""
        record = self._records[robot_id]
        now_s = self._mono_s()
        record.rtt_s, record.rtt_at_s = rtt_s, now_s
        record.rtts.append((now_s, rtt_s))
        while now_s - record.rtts[0][0] > RTT_WINDOW_S:
            record.rtts.popleft()
        self._touch(record, Part.LINK)

    def put_presence(
        self, robot_id: str, *, is_online: bool, is_shutdown: bool = False, received_s: float | None = None
    ) -> None:
        """Take presence or last will. It can only take away: being heard is told by heartbeats that come after it."""
        record = self._records[robot_id]
        record.said_goodbye = is_shutdown and not is_online
        record.gone_s = float("-inf") if is_online else self._mono_s() if received_s is None else received_s
        if record.is_gone == is_online:
            record.is_gone = not is_online
            record.is_online = record.is_heard(self._mono_s())
            self._touch(record, Part.LINK)

    def set_broker(self, *, is_up: bool) -> None:
        """Note whether the console is connected to the broker."""
        if is_up != self._is_broker_up:
            self._is_broker_up = is_up
            for record in self._records.values():
                self._touch(record, Part.LINK)
            self.announce()

    def refresh_links(self) -> None:
        """Judge again who is heard; call a few times a second, since silence makes no message."""
        has_changed = False
        for record in self._records.values():
            is_online = record.is_heard(self._mono_s())
            if is_online != record.is_online:
                record.is_online, has_changed = is_online, True
                self._touch(record, Part.LINK)
        if has_changed:
            self.announce()

    def _add(self, robot_id: str) -> RobotRecord:
        left = self._left.pop(robot_id, None)
        record = self._records[robot_id] = left or RobotRecord(robot_id)
        record.active_s = self._mono_s()
        self._removed.pop(robot_id, None)
        for part in RETAINED_PARTS if left else ():
            self._touch(record, part)
        return record

    def _drop(self, robot_id: str) -> None:
        del self._records[robot_id]
        self._changed.pop(robot_id, None)
        self.revision += 1
        self._removed[robot_id] = self.revision
        if len(self._removed) > REMOVED_KEPT:
            del self._removed[next(iter(self._removed))]

    def _touch(self, record: RobotRecord, part: Part) -> None:
        self.revision += 1
        record.revisions[part] = self.revision
        record.built = None
        self._changed.pop(record.id, None)
        self._changed[record.id] = self.revision
