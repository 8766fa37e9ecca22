"""What is drawn around a watched robot: its work, its way, its obstacles, what it sees."""

from __future__ import annotations

import viser

from backend_clients.edge import machine
from backend_clients.edge import messages_up as up
from hmi.twin.farm import Plan
from hmi.twin.frusta import Frusta
from hmi.twin.ground_frame import SiteFrame
from hmi.twin.groups import Group
from hmi.twin.kinematics import Place
from hmi.twin.limit_marks import LimitMarks
from hmi.twin.machine import Form
from hmi.twin.mover import Mover
from hmi.twin.past import worked_at
from hmi.twin.path import PathLines
from hmi.twin.posture import Posture
from hmi.twin.reach import Reach, draw_reach, reach_of
from hmi.twin.ring import draw_ring
from hmi.twin.scan import draw_scan
from hmi.twin.sightings import Sightings
from hmi.twin.trail import Trail
from hmi.twin.worksite import WorkSurface

WITH_BODY = (Group.KEEPOUT, Group.REACH, Group.LIMITS, Group.CAMERAS)
ON_GROUND = (Group.TREES, Group.OBSTACLES, Group.SCAN, Group.PATH, Group.TRAIL, Group.PARCEL, Group.LABELS)


class SiteView:
    """The surroundings of one robot, in the site's plane; each part draws itself only when it changed."""

    def __init__(self, scene: viser.SceneApi, mover: Mover, robot_id: str) -> None:
        self._scene, self._mover, self._robot_id = scene, mover, robot_id
        for group in ON_GROUND:
            scene.add_frame(group.of(robot_id), show_axes=False)
        for group in WITH_BODY:
            mover.add(group.of(robot_id), Place((0.0, 0.0, 0.0)))
        self.path = PathLines(scene, Group.PATH.of(robot_id), Group.PARCEL.of(robot_id))
        self.trail = Trail(scene, Group.TRAIL.of(robot_id))
        self.surface = WorkSurface(scene, Group.TREES.of(robot_id), worked_at(robot_id), Group.OBSTACLES.of(robot_id))
        self.sightings = Sightings(scene, Group.LABELS.of(robot_id))
        self.limits = LimitMarks(scene, Group.LIMITS.of(robot_id))
        self.frusta = Frusta(scene, Group.CAMERAS.of(robot_id))
        self._keep_out_m = -1.0
        self._scan_seq = -1
        self._form: Form | None = None
        self._joints: list[machine.Joint] = []
        self.reach: Reach | None = None

    def set_plan(self, plan: Plan, frame: SiteFrame) -> None:
        """Draw another plan."""
        self.path.set_plan(plan, frame)
        self.surface.set_before(plan.treated)

    def show(
        self,
        *,
        shift: tuple[float, float],
        posture: Posture,
        form: Form,
        factsheet: up.Factsheet,
        keep_out_m: float,
        body: machine.Body | None,
        worksite: machine.Worksite | None,
        scan: machine.Scan | None,
        order: up.OrderState | None,
        now_ms: int,
    ) -> None:
        """Bring everything up to date. ``shift`` is where the robot's datum lies in the site's plane, now is UTC."""
        self.trail.add(posture.body.xyz)
        self.path.show(order)
        self.surface.show(worksite, shift, now_ms)
        self._ring(posture, keep_out_m)
        self.limits.show(form, posture, factsheet)
        self._parts_of(form, posture, factsheet)
        self._mover.move(Group.LIMITS.of(self._robot_id), posture.body)
        self.sightings.show([] if body is None else body.seen, shift, keep_out_m)
        if scan is not None and scan.seq != self._scan_seq:
            self._scan_seq = scan.seq
            draw_scan(self._scene, f"{Group.SCAN.of(self._robot_id)}/points", scan, shift)

    def remove(self) -> None:
        """Take it all away."""
        for group in ON_GROUND:
            self._scene.remove_by_name(group.of(self._robot_id))
        for group in WITH_BODY:
            self._mover.remove(group.of(self._robot_id))

    def _parts_of(self, form: Form, posture: Posture, factsheet: up.Factsheet) -> None:
        """What hangs on the model and its factsheet: cameras, and how far the arm reaches."""
        cameras, arc = Group.CAMERAS.of(self._robot_id), Group.REACH.of(self._robot_id)
        self._mover.move(cameras, posture.body)
        self._mover.move(arc, posture.body)
        self.frusta.show(form, posture.joints, factsheet.cameras)
        if form is not self._form or factsheet.joints != self._joints:
            self._form, self._joints = form, factsheet.joints
            self.reach = reach_of(form, factsheet.joints)
            draw_reach(self._scene, f"{arc}/line", self.reach)

    def _ring(self, posture: Posture, keep_out_m: float) -> None:
        frame = Group.KEEPOUT.of(self._robot_id)
        self._mover.move(frame, posture.body)
        if keep_out_m != self._keep_out_m:
            self._keep_out_m = keep_out_m
            draw_ring(self._scene, f"{frame}/ring", keep_out_m)
