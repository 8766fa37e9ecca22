"""What is recorded without anybody pressing a button: clips around STOPs and alarms, pictures of missions.

The camera process keeps the last minute of cameras that are open; this says which are held open, and when a clip is
cut. Looking costs a few comparisons for each change of a robot; nothing is asked of the camera process while nothing
happens.
"""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import StrEnum

from hmi.clock import Clock
from hmi.commands.camera_ports import CameraProcess, CamerasAway, NoPicture
from hmi.commands.clip_keeper import ClipKeeper
from hmi.commands.mission_pictures import MissionPictures
from hmi.domain.alarm.live_alarm import Step, What
from hmi.domain.alarm.priority import Priority
from hmi.domain.incident import IncidentBook
from hmi.domain.picture import UNDER_WAY, Moment
from hmi.domain.robot import Mode, Robot, SafetyState

ROUND_S = 1.0
LOOK_S = 2.0
MOST_WATCHED = 16  # a wall of pictures
AGAIN_S = 10.0  # a camera process that was started anew knows nothing of what it should hold
DRIVES_MPS = 0.05
log = logging.getLogger(__name__)


class Recording(StrEnum):
    """Which cameras keep their last minute without anybody looking."""

    DRIVING = "driving"
    """Those somebody looks at, and the first camera of each robot that drives or works, up to a number."""
    WATCHED = "watched"
    """Those somebody looks at, and one of a robot while it has a STOP or an urgent alarm."""
    OFF = "off"


@dataclass(frozen=True, slots=True)
class RecorderParts:
    """What the recorder is wired to.

    Attributes:
        cameras_of: ids of a robot's cameras, the first is held.
        moment_of: where a robot is and what it does, at a time of the console's monotonic clock.
        has_room: whether the disk takes more.
    """

    process: CameraProcess
    clips: ClipKeeper
    missions: MissionPictures
    clock: Clock
    cameras_of: Callable[[str], Sequence[str]]
    moment_of: Callable[[str, float], Moment]
    has_room: Callable[[], bool]
    mode: Recording
    most: int


class CameraRecorder:
    """Follows robots and alarms; one for a console, on its event loop."""

    def __init__(self, parts: RecorderParts) -> None:
        self._parts = parts
        self._incidents = IncidentBook()
        self._latched: dict[str, bool] = {}
        self._driving: dict[str, float] = {}
        self._by_hand: set[str] = set()
        self._held: tuple[tuple[str, str], ...] = ()
        self._told_s = self._looked_s = float("-inf")
        self._watched: list[tuple[str, str]] = []
        self._task: asyncio.Task[None] | None = None

    def start(self) -> None:
        """Begin."""
        if self._parts.mode is not Recording.OFF:
            self._task = asyncio.get_running_loop().create_task(self._rounds(), name="camera-recorder")

    async def stop(self) -> None:
        """End; what is being written is finished, an incident that is open is not."""
        if self._task is not None:
            self._task.cancel()
            await asyncio.gather(self._task, return_exceptions=True)
        await self._parts.missions.close()
        await self._parts.clips.close()

    # ---- what is heard ----

    def stopped(self, robot_id: str, by: str) -> None:
        """Take a press of STOP; the robot's own word for it follows and is the same incident."""
        self._note(robot_id, "stop", f"{by} pressed STOP.", is_grave=True)

    def alarm(self, step: Step) -> None:
        """Take a step in the life of an alarm."""
        if step.what is not What.RAISED:
            return
        live = step.live
        text = live.type.title if not live.alarm.text else f"{live.type.title}: {live.alarm.text}"
        is_grave = live.priority <= Priority.HIGH
        self._note(live.alarm.key.source, f"alarm.{live.id}", text, is_grave=is_grave)

    def see(self, robot: Robot) -> None:
        """Look at a robot that changed."""
        if robot.safety is not None:
            self._see_latch(robot.id, robot.safety)
        self._parts.missions.see(robot)
        if self._parts.mode is Recording.DRIVING:
            if _is_at_work(robot):
                self._driving.setdefault(robot.id, self._parts.clock.mono_s())
            else:
                self._driving.pop(robot.id, None)
            if robot.id in self._driving and robot.state is not None and robot.state.mode is Mode.MANUAL:
                self._by_hand.add(robot.id)
            else:
                self._by_hand.discard(robot.id)

    def _see_latch(self, robot_id: str, safety: SafetyState) -> None:
        is_latched = safety.latched or safety.hardware_stop
        was_latched = self._latched.get(robot_id, is_latched)  # what holds when it is first heard is not news
        self._latched[robot_id] = is_latched
        if not is_latched or was_latched:
            return
        presses = [one for one in safety.presses if not one.is_reset]
        if not presses:
            self._note(
                robot_id, "stop", "The STOP button on the machine." if safety.hardware_stop else "", is_grave=True
            )
        for one in presses:
            self._note(robot_id, f"stop.{one.stop_id}", f"{one.by} pressed STOP.", is_grave=True)

    def _note(self, robot_id: str, cause: str, text: str, *, is_grave: bool) -> None:
        parts = self._parts
        if parts.mode is Recording.OFF or not parts.cameras_of(robot_id):
            return
        now_s = parts.clock.mono_s()
        self._incidents.note(robot_id, cause, text, now_s, parts.clock.utc(),
                             lambda: parts.moment_of(robot_id, now_s), is_grave=is_grave)  # fmt: skip

    # ---- once a second ----

    def wanted(self) -> tuple[tuple[str, str], ...]:
        """Return the cameras that should be held: of incidents, of who is driven by hand, of who drives longest."""
        if not self._parts.has_room():
            return ()
        driving = sorted(self._driving, key=lambda robot_id: (robot_id not in self._by_hand, self._driving[robot_id]))
        robots = list(dict.fromkeys([*self._incidents.grave(), *driving]))
        cameras = ((robot_id, self._parts.cameras_of(robot_id)) for robot_id in robots)
        firsts = [(robot_id, of[0]) for robot_id, of in cameras if of]
        return tuple(dict.fromkeys([*firsts[: self._parts.most], *self._watched[:MOST_WATCHED]]))

    async def round(self) -> None:
        """Tell the camera process what to hold if that changed, and cut clips of what is over."""
        now_s = self._parts.clock.mono_s()
        if now_s - self._looked_s >= LOOK_S:
            await self._look(now_s)
        wanted = self.wanted()
        if wanted != self._held or (wanted and now_s - self._told_s >= AGAIN_S):
            try:
                await self._parts.process.record(wanted)
                self._held, self._told_s = wanted, now_s
            except CamerasAway:
                log.debug("the camera process is away: nothing is recorded")
        for one in self._incidents.over(now_s):
            self._parts.clips.cut(one, self._parts.cameras_of(one.robot_id))

    async def _look(self, now_s: float) -> None:
        """Learn what is open anyway: keeping its last minute costs little more."""
        self._looked_s = now_s
        try:
            self._watched = sorted(await self._parts.process.watched())
        except CamerasAway:
            self._watched = []

    async def _rounds(self) -> None:
        while True:
            try:
                await self.round()
            except NoPicture as error:
                log.info("nothing is recorded: %s", error)
            except Exception:  # the next round must come
                log.exception("a round of the camera recorder failed")
            await asyncio.sleep(ROUND_S)


def _is_at_work(robot: Robot) -> bool:
    """Whether a robot drives or has a mission under way; one that is not heard does not."""
    if not robot.link.is_online:
        return False
    state = robot.state
    if state is not None and (state.mode is Mode.MANUAL or (state.order and state.order.status in UNDER_WAY)):
        return True
    return robot.telemetry is not None and abs(robot.telemetry.pose.speed_mps) > DRIVES_MPS
