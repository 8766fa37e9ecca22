"""One mission on the robot: its route, how far it is, and what has been treated."""

from __future__ import annotations

import math

from msgspec.structs import replace

from backend_clients.edge import messages_up as up
from backend_clients.edge.codec import mission_hash
from backend_clients.edge.fields import OrderStatus
from backend_clients.edge.messages_down import Mission, Segment
from backend_clients.simulator.enu import EnuFrame, Point
from backend_clients.simulator.families import WEEDER
from backend_clients.simulator.journal import Journal
from backend_clients.simulator.profile import Profile
from backend_clients.simulator.route import Leg, Route
from backend_clients.simulator.state_folder import SavedProgress
from backend_clients.simulator.tracking import tracker_on

AT_HOME_M = 0.5
MOVED_LIMIT_M = 0.2
REJOIN_AHEAD_M = 30.0
ROLL_OUT_M = 2.0  # more than braking takes from full speed
_DONE = {"weed": ("weeds", "treated"), "plant": ("trees", "planted"), "survey": ("", "searched")}


class MissionRun:
    """Progress of a loaded mission; moves nothing by itself.

    Args:
        mission: the document as received.
        frame: the robot's ENU frame.
        home: where the robot goes when the mission names no home, in the robot's frame.
        profile: what machine it is.

    Raises:
        RouteError: the path cannot be driven.
    """

    def __init__(self, mission: Mission, frame: EnuFrame, home: Point, profile: Profile = WEEDER) -> None:
        self.mission, self._profile = mission, profile
        self.sha256 = mission_hash(mission)
        self.home = frame.from_frame(mission.datum, [mission.home])[0] if mission.home else home
        segments = [replace(s, points=frame.from_frame(mission.datum, s.points)) for s in mission.segments]
        end = segments[-1].points[-1]
        if mission.at_end == "return_home" and math.dist(end, self.home) > AT_HOME_M:
            segments.append(Segment(kind="exit", points=[end, self.home], speed_mps=profile.home_speed_mps))
        self.route = Route(segments, profile.motion)
        self.tracker = tracker_on(self.route)
        self.status: OrderStatus = "loaded"
        self.is_supervised = True
        self.row = 0
        self.treated_m = 0.0
        self.driven_m = 0.0
        self.pause_code = ""
        self.pause_pose: Point | None = None
        self._open_row = 0  # where the tool's work is counted now; 0 is the headland
        self._row_count = 0.0
        self._row_treated_m = 0.0
        self._must_be_on_path = False

    @property
    def is_open(self) -> bool:
        """Whether it is running or paused."""
        return self.status in ("running", "paused")

    @property
    def leg(self) -> Leg:
        """The segment the robot is on."""
        return self.route.leg_at(self.tracker.s_m)

    def begin(self, *, is_supervised: bool) -> None:
        """Run from the first point."""
        self.tracker = tracker_on(self.route)
        self.row, self.treated_m, self.driven_m = 0, 0.0, 0.0
        self._row_count, self._row_treated_m, self._open_row = 0.0, 0.0, 0
        self.run(is_supervised=is_supervised)

    def run(self, *, is_supervised: bool) -> None:
        """Run on from here."""
        self.status, self.is_supervised = "running", is_supervised
        self.pause_code, self.pause_pose = "", None
        self.tracker.align()

    def pause(self, code: str) -> None:
        """Pause; where it comes to rest is noted by ``rest``."""
        self.status, self.pause_code, self.pause_pose = "paused", code, None

    @property
    def is_coming_to_rest(self) -> bool:
        """Whether it is paused but its resting place is not yet known."""
        return self.status == "paused" and self.pause_pose is None

    def rest(self, pose: Point) -> None:
        """Note where it stands; a resume far from here is refused."""
        s = self.tracker.s_m
        self.pause_pose = pose
        rolled_to = self.route.locate(*pose, s, min(s + ROLL_OUT_M, self.route.next_pivot(s + 1e-6)))
        if math.dist(pose, self.route.point_at(rolled_to)) < MOVED_LIMIT_M:
            self.tracker.s_m = rolled_to
        elif self._must_be_on_path:
            # switched off while it ran and found elsewhere: somebody moved it meanwhile
            self.pause_pose = self.route.point_at(s)
        self._must_be_on_path = False

    def take_over(self, base: MissionRun, s_m: float) -> None:
        """Go on with the progress of ``base`` at ``s_m`` of this path; its state stays what it was."""
        self.tracker = tracker_on(self.route, s_m)
        self.row, self.treated_m, self.driven_m = base.row, base.treated_m, base.driven_m
        self._row_count, self._row_treated_m, self._open_row = base._row_count, base._row_treated_m, base._open_row
        self.status, self.is_supervised = base.status, base.is_supervised
        self.pause_code, self.pause_pose = base.pause_code, base.pause_pose

    def count_done(self, until_m: float) -> None:
        """Take the path before ``until_m`` as treated: it was, before this robot had the document."""
        self.treated_m = self.driven_m = 0.0
        for leg in self.route.legs:
            length_m = max(min(leg.end_m, until_m) - leg.own_start_m, 0.0)
            self.treated_m += length_m if leg.is_tool_on else 0.0
            self.row = leg.row if leg.row and length_m > 0 else self.row

    def stand_at(self, s_m: float, pose: Point) -> None:
        """Be paused before ``s_m``, standing at ``pose``: ready to go on from there."""
        self.tracker = tracker_on(self.route, s_m)
        self.status, self.pause_code, self.pause_pose = "paused", "continued", pose

    def moved_m(self, pose: Point) -> float:
        """Return how far it stands from where it was paused."""
        return math.dist(pose, self.pause_pose) if self.pause_pose is not None else 0.0

    def rejoin(self, pose: Point) -> None:
        """Go on from the nearest point of the path ahead."""
        s = self.tracker.s_m
        until = min(s + REJOIN_AHEAD_M, self.route.next_cusp(s))  # beyond it the line comes back over the same ground
        self.tracker.s_m = max(self.route.locate(pose[0], pose[1], s, until), s)

    def advance(
        self,
        before_m: float,
        *,
        is_working: bool,
        count: float,
        journal: Journal,
        mono_ms: int,
        row: int | None = None,
    ) -> None:
        """Count what was driven and treated since ``before_m`` along the line; ``count`` weeds or trees were done.

        ``row``: the row that is worked, if it is not the one of the path here.
        """
        row = self.leg.row if row is None else row
        if row != self._open_row:
            self._close_row(journal, mono_ms)
            self._open_row, self.row = row, row or self.row
        gained = max(self.tracker.s_m - before_m, 0.0)
        self.driven_m += gained
        if is_working:
            self.treated_m += gained
            self._row_treated_m += gained
            self._row_count += count

    def finish(self, journal: Journal, mono_ms: int) -> None:
        """The last point is reached."""
        self._close_row(journal, mono_ms)
        self.status = "done"

    def order_state(self) -> up.OrderState:
        """Return progress as the console sees it."""
        share = min(self.treated_m / self.route.tool_m, 1.0) if self.route.tool_m else 0.0
        remaining = self.route.remaining_s(self.tracker.s_m) if self.status != "done" else 0.0
        leg = self.leg
        return up.OrderState(
            mission_id=self.mission.mission_id,
            revision=self.mission.revision,
            sha256=self.sha256,
            status=self.status,
            row=self.row,
            rows=self.route.rows,
            segment=min(leg.index, len(self.mission.segments) - 1),
            segment_s_m=round(max(self.tracker.s_m - leg.own_start_m, 0.0), 2),
            area_m2=self.mission.area_m2,
            area_done_m2=round(self.mission.area_m2 * share, 1),
            distance_m=round(self.driven_m, 1),
            remaining_s=round(remaining, 1),
            is_supervised=self.is_supervised,
        )

    def save_into(self, saved: SavedProgress) -> None:
        """Write what has to survive a reboot into ``saved``."""
        saved.status, saved.sha256, saved.s_m = self.status, self.sha256, self.tracker.s_m
        saved.row, saved.treated_m, saved.driven_m = self.row, self.treated_m, self.driven_m
        saved.row_treated_m, saved.row_weeds = self._row_treated_m, self._row_count
        saved.is_supervised, saved.pause_code, saved.pause_pose = self.is_supervised, self.pause_code, self.pause_pose

    def restore(self, saved: SavedProgress) -> None:
        """Take up the progress of an earlier boot; what ran is paused now."""
        if saved.sha256 != self.sha256:
            return
        self.tracker = tracker_on(self.route, min(saved.s_m, self.route.length_m))
        self.row, self.treated_m, self.driven_m = saved.row, saved.treated_m, saved.driven_m
        self._row_treated_m, self._row_count, self._open_row = saved.row_treated_m, saved.row_weeds, self.leg.row
        self.is_supervised = saved.is_supervised
        if saved.status in ("running", "paused"):
            self.pause((saved.pause_code if saved.status == "paused" else "") or "rebooted")
            self.pause_pose = saved.pause_pose
            self._must_be_on_path = saved.pause_pose is None
        elif saved.status in ("done", "aborted", "failed"):
            self.status = saved.status  # type: ignore[assignment]

    def _close_row(self, journal: Journal, mono_ms: int) -> None:
        row, name = self._open_row, f"Row {self._open_row}" if self._open_row else "Headland"
        if self._row_treated_m > 0:
            length_m, done = round(self._row_treated_m, 2), round(self._row_count)
            what, words = _DONE[self._profile.work]
            facts = {what: done} if what else {}
            journal.event(
                mono_ms,
                "treatment",
                f"{name} {words}",
                f"{done} {what} on {length_m:.0f} m" if what else f"{length_m:.0f} m",
                row=row,
                length_m=length_m,
                mission_id=self.mission.mission_id,
                **facts,
            )
        self._row_count = self._row_treated_m = 0.0
