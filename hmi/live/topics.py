"""What a topic holds: the newest groups, what of them changed, each encoded once however many lanes listen."""

from __future__ import annotations

import struct
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from hmi.domain.robot import Pose, Robot
from hmi.live.frames import ALARMS, FLEET, POSES, ROBOT, piece
from hmi.presenters import fleet, operate
from hmi.store.fleet import Part

GROUPS_OF: dict[Part, tuple[str, ...]] = {
    Part.REGISTRY: ("id", "tiles", "why", "actions", "body"),
    Part.LINK: ("link", "tiles", "why", "actions", "checks"),
    Part.FACTSHEET: ("id", "tiles", "body"),
    Part.TELEMETRY: ("pose", "tiles", "checks"),
    Part.STATE: ("mode", "mission", "supervisor", "tiles", "why", "actions", "checks", "faults"),
    Part.SAFETY: ("mode", "safety", "tiles", "why", "actions"),
    Part.NODES: (),
}


class RobotTopic:
    """Topic ``robot/{id}``: groups, each kept as the JSON that was sent last."""

    def __init__(self, robot_id: str) -> None:
        self.robot_id = robot_id
        self.name = ROBOT + robot_id
        self._groups: dict[str, str] = {}
        self._whole: str | None = None

    def update(self, robot: Robot | None, context: operate.Context, parts: Iterable[Part]) -> str | None:
        """Take over what changed; return the changed groups as JSON, ``None`` if nothing did."""
        names = {name for part in parts for name in GROUPS_OF[part]}
        values = operate.present(robot, context, names) if robot is not None else dict.fromkeys(names)
        return self.put(values)

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


class FleetTopic:
    """Topic ``fleet``: one entry a robot; deltas carry only the entries that changed, ``null`` for one that left."""

    name = FLEET

    def __init__(self) -> None:
        self._entries: dict[str, str] = {}
        self._whole: str | None = None

    def update(self, robots: Iterable[Robot], removed: Iterable[str]) -> str | None:
        """Take over changed robots; return the changed entries as JSON, ``None`` if nothing changed."""
        changed = []
        for robot in robots:
            text = piece(fleet.entry(robot))
            if self._entries.get(robot.id) != text:
                self._entries[robot.id] = text
                changed.append(f'"{robot.id}":{text}')
        for robot_id in removed:
            if self._entries.pop(robot_id, None) is not None:
                changed.append(f'"{robot_id}":null')
        if not changed:
            return None
        self._whole = None
        return '{"robots":{' + ",".join(changed) + "}}"

    def whole(self) -> str:
        """Return every entry as JSON."""
        if self._whole is None:
            self._whole = '{"robots":{' + ",".join(f'"{i}":{t}' for i, t in self._entries.items()) + "}}"
        return self._whole


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
MAGIC = b"HLP1"
AGE_UNITS_PER_S, AGE_MAX = 100, 65_535
DEG_PER_RAD = 57.29577951308232


class PosesTopic:
    """Topic ``poses``: where every robot is, ten times a second, as one binary frame of all that moved.

    A robot is named by a number that ``names`` gives and that never changes while the console runs.
    """

    name = POSES

    def __init__(self) -> None:
        self._numbers: dict[str, int] = {}

    def number(self, robot_id: str) -> int:
        """Return the number that stands for a robot in binary frames."""
        return self._numbers.setdefault(robot_id, len(self._numbers))

    def names(self) -> str:
        """Return the number of every robot as JSON."""
        return '{"numbers":' + piece(self._numbers) + "}"

    @property
    def known(self) -> int:
        """How many robots have a number."""
        return len(self._numbers)

    def frame(self, revision: int, now_s: float, moved: Sequence[tuple[str, Pose]]) -> bytes:
        """Return one binary frame: see docs/protocols/lane.md for its layout."""
        frame = bytearray(_HEAD.size + _POSE.size * len(moved))
        _HEAD.pack_into(frame, 0, MAGIC, revision & 0xFFFFFFFF, now_s * 1000, len(moved))
        at, numbers, pack_into = _HEAD.size, self._numbers, _POSE.pack_into
        for robot_id, pose in moved:
            number = numbers.get(robot_id)
            if number is None:
                number = self.number(robot_id)
            age = min(AGE_MAX, max(0, int((now_s - pose.stamp.source_s) * AGE_UNITS_PER_S)))
            heading = int((90.0 - pose.theta_rad * DEG_PER_RAD) % 360.0 * 100) % 36_000
            pack_into(frame, at, number, round(pose.lat_deg * 1e7), round(pose.lon_deg * 1e7), heading, age)
            at += _POSE.size
        return bytes(frame)
