"""Ten ticks a second, one encoding a topic, any number of lanes.

Everything here runs on the event loop and never waits for a browser: each lane takes what it can, see ``outbox``.
"""

from __future__ import annotations

import asyncio
import contextlib
import logging
from collections.abc import Callable, Iterable, Iterator
from typing import Any, Protocol

from hmi.clock import Clock
from hmi.domain.freshness import TickRing
from hmi.domain.robot import Robot
from hmi.live import frames
from hmi.live.inside import InsideTopic
from hmi.live.outbox import Outbox
from hmi.live.topics import AlarmsTopic, FleetTopic, PosesTopic, RobotNumbers, RobotTopic
from hmi.presenters.operate import Context, IsSupervised, MissionTitle
from hmi.presenters.start_checks import MissionFacts
from hmi.store.fleet import FleetStore
from hmi.store.robot_record import ALL_PARTS, Part

log = logging.getLogger(__name__)

TICK_S = 0.1
# A change is sent at once, the next one after this: 10 Hz telemetry is never held back, and what comes close together
# is one picture in the browser. Rests of 4 ms tripled the delay to the screen: it painted each part alone.
FLUSH_S = 0.04
FLEET_S = 0.5  # lists are read by people
CROWD = 100  # of so many robots nobody follows one: places go out at the rate of the lists
REVIEW_S = 5.0  # battery and accuracy drift slowly: an entry that only moved is looked at again this often
_LISTS = frozenset({frames.FLEET, frames.ALARMS, frames.POSES})
_FAST_PARTS = frozenset({Part.TELEMETRY, Part.LINK})
TitleOf = Callable[[str], MissionTitle | None]
FactsOf = Callable[[str], MissionFacts | None]
_NO_PARTS: frozenset[Part] = frozenset()


class AlarmSource(Protocol):
    """Where the entries of topic ``alarms`` come from; answers from memory."""

    @property
    def revision(self) -> int:
        """Grows with every change."""
        ...

    def entries_since(self, revision: int) -> dict[str, dict[str, Any] | None]:
        """Return the entries that changed after a revision, ``None`` for one that is normal again."""
        ...

    def summary(self) -> dict[str, Any]:
        """Return counts, flood, and when the supervision last looked."""
        ...


class NoAlarms:
    """Nothing watches."""

    revision = 0

    def entries_since(self, revision: int) -> dict[str, dict[str, Any] | None]:
        """See ``AlarmSource``."""
        return {}

    def summary(self) -> dict[str, Any]:
        """See ``AlarmSource``."""
        return {"counts": {}, "flood": None, "checked": None}


class LiveHub:
    """Between the fleet store and the lanes.

    Args:
        store: read, and listened to for changes.
        ticks: issues the tick ids that orders must echo.
        clock: the console's clocks.
        title_of: mission id to what people call it; answers from memory.
        facts_of: mission id to what the start checks need; answers from memory.
        alarms: what topic ``alarms`` shows.
        is_supervised: whether somebody has to look on while a robot carries out what it has; answers from memory.
        crowd: robots beyond which places go out twice a second and not ten times.
    """

    def __init__(
        self,
        store: FleetStore,
        ticks: TickRing,
        clock: Clock,
        title_of: TitleOf = lambda _mission_id: None,
        facts_of: FactsOf = lambda _mission_id: None,
        alarms: AlarmSource | None = None,
        *,
        is_supervised: IsSupervised = lambda _robot, _order: True,
        crowd: int = CROWD,
    ) -> None:
        self._crowd = crowd
        self._store, self._ticks, self._clock, self._title_of = store, ticks, clock, title_of
        self._facts_of, self._is_supervised = facts_of, is_supervised
        self._lanes: set[Outbox] = set()
        self._robots: dict[str, RobotTopic] = {}
        self._insides: dict[str, InsideTopic] = {}
        self._extras: dict[str, dict[str, Any]] = {}
        self._numbers = RobotNumbers()
        self._fleet, self._poses = FleetTopic(self._numbers), PosesTopic(self._numbers)
        self._fleet_context = Context(title_of=title_of)
        self._online: dict[str, bool] = {}
        self._reviewed: dict[str, float] = {}
        self._beats_seen = self._numbers_told = 0
        self._alarms, self._alarm_source = AlarmsTopic(), alarms or NoAlarms()
        self._listeners: dict[str, set[Outbox]] = {}
        self._seen = self._fleet_seen = self._poses_seen = self._alarms_seen = 0
        self._lists_due_s = float("-inf")
        self._revision = 0
        self._changed = asyncio.Event()
        self._tasks: list[asyncio.Task[None]] = []
        self._unsubscribe: Callable[[], None] = lambda: None
        self.stop_state = "unknown"
        self.keeper: list[dict[str, Any]] = []

    @property
    def boot(self) -> str:
        """Names this run of the console."""
        return self._ticks.boot

    @property
    def lanes(self) -> int:
        """How many browsers are connected."""
        return len(self._lanes)

    async def start(self) -> None:
        """Begin to tick and to send."""
        self._unsubscribe = self._store.subscribe(self._changed.set)
        self._tasks = [
            asyncio.create_task(self._tick_forever(), name="live-tick"),
            asyncio.create_task(self._flush_forever(), name="live-flush"),
        ]

    async def stop(self) -> None:
        """End the tasks; the lanes end when the server closes them."""
        self._unsubscribe()
        for task in self._tasks:
            task.cancel()
        await asyncio.gather(*self._tasks, return_exceptions=True)
        self._tasks = []

    def attach(self, lane: Outbox) -> None:
        """Take a lane in; it hears ticks and events from now on, topics after ``subscribe``."""
        self._lanes.add(lane)

    def detach(self, lane: Outbox) -> None:
        """Forget a lane."""
        if lane in self._lanes:
            self._lanes.discard(lane)
            self._leave(lane, lane.topics)

    def subscribe(self, lane: Outbox, topics: list[str]) -> None:
        """Replace what a lane listens to; it gets a snapshot next."""
        chosen = tuple(dict.fromkeys(t for t in topics if frames.is_topic(t)))
        self._join(lane, chosen)
        self._leave(lane, set(lane.topics) - set(chosen))
        lane.topics = chosen
        lane.wants_snapshot()

    def set_group(self, robot_id: str, group: str, value: Any) -> None:
        """Set a group that is not the robot's own, such as ``lease``; sent with the next flush."""
        self._extras.setdefault(robot_id, {})[group] = value
        topic = self._robots.get(robot_id)
        if topic is not None:
            self._send(topic.name, topic.put({group: value}))

    def event(self, data: dict[str, Any], *, session_id: str | None = None) -> None:
        """Tell something discrete to every lane, or to those of one session; never conflated."""
        text = frames.encode({"k": "event", "d": data})
        for lane in self._lanes:
            if session_id is None or lane.session_id == session_id:
                lane.event(text)

    def end_session(self, session_id: str, code: str, text: str) -> None:
        """Say ``bye`` to every lane of a session that ended and close them."""
        for lane in self._lanes:
            if lane.session_id == session_id:
                lane.bye(code, text)

    def snapshot(self, lane: Outbox) -> str:
        """Return the full state of what a lane listens to."""
        return frames.snapshot(self._revision, [(name, self._whole(name)) for name in lane.topics])

    def beat(self) -> None:
        """Issue a tick and hand it to every lane, with the lists that are due; called ten times a second."""
        self._send_lists()
        tick = self._ticks.issue()
        frame: dict[str, Any] = {"k": "tick", "id": tick.id, "m": round(tick.at_s * 1000, 1), "stop": self.stop_state}
        frame["keeper"] = self.keeper
        text = frames.encode(frame)
        for lane in self._lanes:
            lane.tick(text)

    def flush(self) -> None:
        """Send what changed since the last time, as far as anybody listens."""
        changes = self._store.since(self._seen)
        self._seen = changes.revision
        for robot_id, inside in self._insides.items():
            inside.note(ALL_PARTS if robot_id in changes.removed else changes.robots.get(robot_id, _NO_PARTS))
        for robot_id, topic in self._robots.items():
            parts = ALL_PARTS if robot_id in changes.removed else changes.robots.get(robot_id, _NO_PARTS)
            if parts:
                with _alone(topic.name):
                    robot = self._store.robot(robot_id)
                    self._send(topic.name, topic.update(robot, self._context(robot_id), parts))

    def _send_lists(self) -> None:
        # With the tick and not with each change: a lane wakes once for both.
        now_s = self._clock.mono_s()
        for robot_id, inside in self._insides.items():
            with _alone(inside.name):
                self._send(inside.name, inside.update(self._store.robot(robot_id), now_s))
        are_due = now_s >= self._lists_due_s and not self._listeners.keys().isdisjoint(_LISTS)
        if are_due:  # all at once: a browser draws once for list, map and figures
            self._lists_due_s = now_s + FLEET_S - TICK_S / 2  # a beat that comes a little early still counts
        if are_due and frames.FLEET in self._listeners:
            with _alone(frames.FLEET):
                self._send(frames.FLEET, self._update_fleet(now_s))
            self._send_beats(now_s)
        if are_due and frames.ALARMS in self._listeners:
            with _alone(frames.ALARMS):
                self._send(frames.ALARMS, self._update_alarms())
        if frames.POSES in self._listeners and (are_due or len(self._numbers) <= self._crowd):
            with _alone(frames.POSES):
                self._send_poses(now_s)

    def _update_fleet(self, now_s: float) -> str | None:
        changes = self._store.since(self._fleet_seen)
        self._fleet_seen = changes.revision
        wanted = [robot_id for robot_id, parts in changes.robots.items() if self._is_due(robot_id, parts, now_s)]
        for robot_id in changes.removed:
            self._online.pop(robot_id, None)
            self._reviewed.pop(robot_id, None)
        return self._fleet.update(self._known(wanted), changes.removed, self._fleet_context)

    def _is_due(self, robot_id: str, parts: Iterable[Part], now_s: float) -> bool:
        """Say whether an entry may have changed; making one for each robot that only moved would cost the most."""
        is_online = self._store.is_online(robot_id)
        is_same = self._online.get(robot_id) == is_online and _FAST_PARTS.issuperset(parts)
        if is_same and now_s - self._reviewed.get(robot_id, 0.0) < REVIEW_S:
            return False
        self._online[robot_id], self._reviewed[robot_id] = is_online, now_s
        return True

    def _send_beats(self, now_s: float) -> None:
        heard = self._store.beats_since(self._beats_seen)
        self._beats_seen = self._store.revision
        if heard:
            self._revision += 1
            frame = self._fleet.beats(self._revision, now_s, heard)
            for lane in self._listeners[frames.FLEET]:
                lane.delta(frame)

    def _update_alarms(self) -> str | None:
        source = self._alarm_source
        changed = source.entries_since(self._alarms_seen)
        self._alarms_seen = source.revision
        return self._alarms.update(changed, source.summary())

    def _send_poses(self, now_s: float) -> None:
        moved = self._store.moved_since(self._poses_seen)
        self._poses_seen = self._store.revision
        if not moved:
            return
        self._revision += 1
        frame = self._poses.frame(self._revision, now_s, moved)
        has_new_names = len(self._numbers) != self._numbers_told
        self._numbers_told = len(self._numbers)
        for lane in self._listeners[frames.POSES]:
            if has_new_names:
                lane.wants_snapshot()
            else:
                lane.delta(frame)

    def _known(self, robot_ids: Iterable[str]) -> list[Robot]:
        return [robot for i in robot_ids if (robot := self._store.robot(i)) is not None]

    def _send(self, topic: str, groups: str | None) -> None:
        if groups is None:
            return
        self._revision += 1
        text = frames.delta(self._revision, topic, groups)
        for lane in self._listeners.get(topic, ()):
            lane.delta(text)

    def _context(self, robot_id: str) -> Context:
        entry = self._store.registration(robot_id)
        if entry is None:
            return Context("", "", self._title_of, self._facts_of, self._is_supervised)
        contact = (entry.contact_name or "", entry.contact_phone or "")
        return Context(*contact, self._title_of, self._facts_of, self._is_supervised, entry.keep_out_m)

    def _join(self, lane: Outbox, topics: Iterable[str]) -> None:
        for name in topics:
            if name not in self._listeners:
                self._listeners[name] = set()
                self._open(name)
            self._listeners[name].add(lane)

    def _leave(self, lane: Outbox, topics: Iterable[str]) -> None:
        for name in topics:
            self._listeners[name].discard(lane)
            if not self._listeners[name]:
                del self._listeners[name]
                self._robots.pop(name.removeprefix(frames.ROBOT), None)
                self._insides.pop(name.removeprefix(frames.INSIDE), None)

    def _open(self, name: str) -> None:
        """Bring a topic up to date that nobody listened to until now."""
        if name == frames.FLEET:
            with _alone(name):
                self._update_fleet(self._clock.mono_s())
        elif name == frames.ALARMS:
            self._alarms, self._alarms_seen = AlarmsTopic(), 0
            with _alone(name):
                self._update_alarms()
        elif name.startswith(frames.INSIDE):
            inside = InsideTopic(name.removeprefix(frames.INSIDE))
            self._insides[inside.robot_id] = inside
            with _alone(name):
                inside.update(self._store.robot(inside.robot_id), self._clock.mono_s())
        elif name.startswith(frames.ROBOT):
            robot_id = name.removeprefix(frames.ROBOT)
            topic = self._robots[robot_id] = RobotTopic(robot_id)
            with _alone(name):
                topic.update(self._store.robot(robot_id), self._context(robot_id), ALL_PARTS)
            topic.put({"lease": None, **self._extras.get(robot_id, {})})

    def _whole(self, name: str) -> str:
        if name == frames.FLEET:
            return self._fleet.whole(self._store.beats())
        if name == frames.ALARMS:
            return self._alarms.whole()
        if name == frames.POSES:
            return self._poses.whole((one.robot_id for one in self._store.beats()), self._store.places())
        if name.startswith(frames.INSIDE):
            return self._insides[name.removeprefix(frames.INSIDE)].whole()
        return self._robots[name.removeprefix(frames.ROBOT)].whole()

    async def _tick_forever(self) -> None:
        loop = asyncio.get_running_loop()
        due_s = loop.time()
        while True:
            try:
                self.beat()
            except Exception:  # the next tick must come
                log.exception("a beat of the live lane failed")
            due_s = max(due_s + TICK_S, loop.time() - TICK_S)
            await asyncio.sleep(due_s - loop.time())

    async def _flush_forever(self) -> None:
        while True:
            await self._changed.wait()
            self._changed.clear()
            try:
                self.flush()
            except Exception:  # one value that cannot be shown must not stop the others
                log.exception("a flush of the live lane failed")
            await asyncio.sleep(FLUSH_S)


@contextlib.contextmanager
def _alone(topic: str) -> Iterator[None]:
    """Let what cannot be shown stop nothing else: changes are told once, and without a tick nobody may order."""
    try:
        yield
    except Exception:
        log.exception("topic %s of the live lane failed", topic)
