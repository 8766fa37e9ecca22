"""What a topic holds: the newest groups, what of them changed, each encoded once however many lanes listen."""

from __future__ import annotations

import logging
import struct
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from hmi.domain.robot import Pose, Robot
from hmi.live.frames import ALARMS, FLEET, POSES, ROBOT, piece
from hmi.presenters import fleet, operate
from hmi.presenters.units import heading_deg, milliseconds
from hmi.store.fleet import Beat
from hmi.store.robot_record import Part

GROUPS_OF: dict[Part, tuple[str, ...]] = {
    Part.REGISTRY: ("id", "tiles", "why", "actions", "body"),
    Part.LINK: ("link", "tiles", "why", "actions", "checks"),
    Part.FACTSHEET: ("id", "tiles", "body"),
    Part.TELEMETRY: ("pose", "tiles", "checks"),
    Part.STATE: ("mode", "mission", "supervisor", "tiles", "why", "actions", "checks", "faults"),
    Part.SAFETY: ("mode", "safety", "tiles", "why", "actions"),
    Part.NODES: (),
    Part.BODY: (),
    Part.WORKSITE: (),
    Part.SIGHT: (),
}


log = logging.getLogger(__name__)


class Groups:
    """Named groups of a topic, each kept as the JSON that was sent last."""

    def __init__(self) -> None:
        self._groups: dict[str, str] = {}
        self._whole: str | None = None

    def put(self, values: dict[str, Any]) -> str | None:
        """Replace groups; return those that differ as JSON, ``None`` if none does."""
        changed = []
        for name, value in values.items():
            text = piece(value)
            if self._groups.get(name) != text:
                self._groups[name] = text
                changed.append(f'"{name}":{text}')
        if not changed:
            return None
        self._whole = None
        return "{" + ",".join(changed) + "}"

    def whole(self) -> str:
        """Return all groups as JSON."""
        if self._whole is None:
            self._whole = "{" + ",".join(f'"{name}":{text}' for name, text in self._groups.items()) + "}"
        return self._whole


class RobotTopic(Groups):
    """Topic ``robot/{id}``."""

    def __init__(self, robot_id: str) -> None:
        super().__init__()
        self.robot_id = robot_id
        self.name = ROBOT + robot_id

    def update(self, robot: Robot | None, context: operate.Context, parts: Iterable[Part]) -> str | None:
        """Take over what changed; return the changed groups as JSON, ``None`` if nothing did."""
        names = {name for part in parts for name in GROUPS_OF[part]}
        values = operate.present(robot, context, names) if robot is not None else dict.fromkeys(names)
        return self.put(values)


class RobotNumbers:
    """The number that stands for a robot in binary frames; it never changes while the console runs."""

    def __init__(self) -> None:
        self._numbers: dict[str, int] = {}

    def of(self, robot_id: str) -> int:
        """Return a robot's number; a new robot gets the next one."""
        return self._numbers.setdefault(robot_id, len(self._numbers))

    def all(self) -> dict[str, int]:
        """Return every number given so far."""
        return self._numbers

    def __len__(self) -> int:
        """How many robots have a number."""
        return len(self._numbers)


class FleetTopic:
    """Topic ``fleet``: one entry a robot; deltas carry of each only what changed, ``null`` for one that left.

    When a robot was heard and its round trip change all the time; they go out as ``beats``, eight bytes a robot.
    """

    name = FLEET

    def __init__(self, numbers: RobotNumbers) -> None:
        self._numbers = numbers
        self._entries: dict[str, dict[str, Any]] = {}
        self._texts: dict[str, str] = {}
        self._whole: str | None = None
        self._failed: set[str] = set()

    def update(self, robots: Iterable[Robot], removed: Iterable[str], context: operate.Context) -> str | None:
        """Take over changed robots; return what changed of them as JSON, ``None`` if nothing did.

        One that cannot be shown stays as it was, and no beat of it is told until it can: it is old.
        """
        changed = []
        for robot in robots:
            try:
                news = self._news(robot, context)
            except Exception:  # changes are told once: the other robots would stay as they were, and look fresh
                if robot.id not in self._failed:
                    log.exception("%s cannot be shown in the list of robots", robot.id)
                self._failed.add(robot.id)
                continue
            self._failed.discard(robot.id)
            if news:
                changed.append(f'"{robot.id}":{news}')
        for robot_id in removed:
            self._failed.discard(robot_id)
            if self._entries.pop(robot_id, None) is not None:
                self._texts.pop(robot_id, None)
                changed.append(f'"{robot_id}":null')
        if not changed:
            return None
        self._whole = None
        return '{"robots":{' + ",".join(changed) + "}}"

    def _news(self, robot: Robot, context: operate.Context) -> str:
        """Take over a robot; return what changed of it as JSON, empty if nothing did."""
        entry = {"n": self._numbers.of(robot.id), **fleet.slow(robot, context)}
        before = self._entries.get(robot.id, {})
        changed = {key: value for key, value in entry.items() if key not in before or before[key] != value}
        if not changed:
            return ""
        news = piece(changed)
        self._entries[robot.id] = entry
        self._texts.pop(robot.id, None)
        return news

    def has(self, robot_id: str) -> bool:
        """Say whether browsers know this robot as it is now."""
        return robot_id in self._entries and robot_id not in self._failed

    def beats(self, revision: int, now_s: float, heard: Iterable[Beat]) -> bytes:
        """Return one binary frame: see docs/protocols/lane.md for its layout."""
        known = [one for one in heard if self.has(one.robot_id)]
        frame = bytearray(_HEAD.size + _BEAT.size * len(known))
        _HEAD.pack_into(frame, 0, BEATS_MAGIC, revision & 0xFFFFFFFF, now_s * 1000, len(known))
        at = _HEAD.size
        for one in known:
            age = UNKNOWN if one.heard_s is None else _age(now_s - one.heard_s)
            rtt = UNKNOWN if one.rtt_s is None else min(UNKNOWN - 1, round(one.rtt_s * 1000))
            _BEAT.pack_into(frame, at, self._numbers.of(one.robot_id), age, rtt)
            at += _BEAT.size
        return bytes(frame)

    def whole(self, heard: Iterable[Beat]) -> str:
        """Return every entry as JSON, and beside them when each robot was heard."""
        if self._whole is None:
            for robot_id, entry in self._entries.items():
                if robot_id not in self._texts:
                    self._texts[robot_id] = piece(entry)
            self._whole = '"robots":{' + ",".join(f'"{i}":{self._texts[i]}' for i in self._entries) + "}"
        beats = {o.robot_id: [milliseconds(o.heard_s), milliseconds(o.rtt_s)] for o in heard if self.has(o.robot_id)}
        return "{" + self._whole + ',"beats":' + piece(beats) + "}"


class AlarmsTopic:
    """Topic ``alarms``: an entry for each alarm and a summary; deltas carry only the entries that changed."""

    name = ALARMS

    def __init__(self) -> None:
        self._entries: dict[str, str] = {}
        self._summary = "null"

    def update(self, changed: Mapping[str, dict[str, Any] | None], summary: dict[str, Any]) -> str | None:
        """Take over changed entries; return the delta as JSON, ``None`` if nothing changed."""
        moved = []
        for alarm_id, entry in changed.items():
            text = piece(entry)
            if entry is None:
                if self._entries.pop(alarm_id, None) is None:
                    continue
            elif self._entries.get(alarm_id) == text:
                continue
            else:
                self._entries[alarm_id] = text
            moved.append(f'"{alarm_id}":{text}')
        before, self._summary = self._summary, piece(summary)
        if not moved and self._summary == before:
            return None
        return '{"alarms":{' + ",".join(moved) + '},"summary":' + self._summary + "}"

    def whole(self) -> str:
        """Return every entry as JSON."""
        entries = ",".join(f'"{i}":{t}' for i, t in self._entries.items())
        return '{"alarms":{' + entries + '},"summary":' + self._summary + "}"


_HEAD = struct.Struct("<4sIdI")
_POSE = struct.Struct("<IiiHH")
_BEAT = struct.Struct("<IHH")
MAGIC, BEATS_MAGIC = b"HLP1", b"HLB1"
AGE_UNITS_PER_S, AGE_MAX, UNKNOWN = 100, 65_534, 65_535
DEG_PER_RAD = 57.29577951308232


def _age(age_s: float) -> int:
    return min(AGE_MAX, max(0, int(age_s * AGE_UNITS_PER_S)))


class PosesTopic:
    """Topic ``poses``: where every robot is, as one binary frame of all that moved."""

    name = POSES

    def __init__(self, numbers: RobotNumbers) -> None:
        self._numbers = numbers

    def whole(self, robot_ids: Iterable[str], placed: Iterable[tuple[str, Pose]]) -> str:
        """Return the number of every robot, and where each was last, as JSON."""
        for robot_id in robot_ids:
            self._numbers.of(robot_id)
        places = {
            i: [round(p.lat_deg, 7), round(p.lon_deg, 7), heading_deg(p.theta_rad), milliseconds(p.stamp.source_s)]
            for i, p in placed
        }
        return '{"numbers":' + piece(self._numbers.all()) + ',"places":' + piece(places) + "}"

    def frame(self, revision: int, now_s: float, moved: Sequence[tuple[str, Pose]]) -> bytes:
        """Return one binary frame: see docs/protocols/lane.md for its layout."""
        frame = bytearray(_HEAD.size + _POSE.size * len(moved))
        _HEAD.pack_into(frame, 0, MAGIC, revision & 0xFFFFFFFF, now_s * 1000, len(moved))
        at, numbers, pack_into = _HEAD.size, self._numbers.all(), _POSE.pack_into
        for robot_id, pose in moved:
            number = numbers.get(robot_id)
            if number is None:
                number = self._numbers.of(robot_id)
            age = min(AGE_MAX, max(0, int((now_s - pose.stamp.source_s) * AGE_UNITS_PER_S)))
            heading = int((90.0 - pose.theta_rad * DEG_PER_RAD) % 360.0 * 100) % 36_000
            pack_into(frame, at, number, round(pose.lat_deg * 1e7), round(pose.lon_deg * 1e7), heading, age)
            at += _POSE.size
        return bytes(frame)
