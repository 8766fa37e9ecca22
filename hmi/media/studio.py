"""The twin at work: robots from the broker into the world, viewers' wishes into their pictures.

Everything runs on one event loop; viser's own threads only hand over.
"""

from __future__ import annotations

import asyncio
import contextlib
import logging
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import viser

from backend_clients.edge import machine
from backend_clients.edge import messages_up as up
from backend_clients.edge.topics import Up
from hmi.clock import Clock
from hmi.domain.keep_out import keep_out_m
from hmi.media import orders
from hmi.media.door import SECRET_HEADER, VIEWER_HEADER
from hmi.media.ear import Ear
from hmi.media.intake import Intake
from hmi.media.recall import recall
from hmi.media.status import status_of
from hmi.media.tap import base_of, tapped
from hmi.media.whereabouts import posture_of
from hmi.side_door import is_secret
from hmi.twin.farm import Farm, FarmRobot, Last, Plan
from hmi.twin.ground_frame import SiteFrame
from hmi.twin.groups import Group
from hmi.twin.guarded_viser import guarded_viser, headers_of
from hmi.twin.kinematics import Place
from hmi.twin.library import Library
from hmi.twin.moment import Moment
from hmi.twin.posture import Posture
from hmi.twin.site import SiteView
from hmi.twin.viewer import View, Viewer
from hmi.twin.world import World

log = logging.getLogger(__name__)
TICK_S = 0.1
DETAILS_EVERY = 2  # ticks: what hangs around a robot is read by people
STATUS_EVERY = 5


class Studio:
    """Intake, world and viewers. ``start`` and ``stop`` it on the event loop."""

    def __init__(self, intake: Intake, uploads: Path, secret: str, clock: Clock, ear: Ear | None = None) -> None:
        self.intake, self._clock, self._ear = intake, clock, ear
        self.library = Library(uploads)
        self.server = guarded_viser(lambda headers: is_secret(headers.get(SECRET_HEADER), secret))
        self.world = World(self.server)
        self.frame = SiteFrame()
        self.viewers: dict[str, Viewer] = {}
        self.farm: dict[str, FarmRobot] = {}
        self._plans: dict[str, Plan] = {}
        self._last: dict[str, Last] = {}
        self._sites: dict[str, SiteView] = {}
        self._boxes: dict[str, asyncio.Queue[dict[str, Any]]] = {}
        self._loop: asyncio.AbstractEventLoop | None = None
        self._task: asyncio.Task[None] | None = None
        self._round = 0

    @property
    def viser_port(self) -> int:
        """Where viser listens on loopback."""
        return self.server.get_port()

    def start(self) -> None:
        """Begin to draw."""
        self._loop = asyncio.get_running_loop()
        self.server.on_client_connect(self._connected)
        self.server.on_client_disconnect(self._disconnected)
        self._task = self._loop.create_task(self._run(), name="twin")

    async def stop(self) -> None:
        """End viser and the drawing."""
        if self._task is not None:
            self._task.cancel()
            with contextlib.suppress(asyncio.CancelledError):
                await self._task
        self.library.close()
        await asyncio.to_thread(self.server.stop)

    def set_farm(self, farm: Farm) -> None:
        """Take note of who belongs to the farm."""
        self.farm = {robot.id: robot for robot in farm.robots}
        self.intake.own(self.farm)
        for robot_id in [one for one in self.world.robots() if one not in self.farm]:
            self.world.remove(robot_id)

    def set_plan(self, robot_id: str, plan: Plan) -> None:
        """Take note of what a robot works on."""
        self._plans[robot_id] = plan
        if robot_id in self._sites:
            self._sites[robot_id].set_plan(plan, self.frame)

    def set_last(self, lasts: Mapping[str, Last]) -> None:
        """Take note of where robots were before anybody listened here; the newest of that and what they say counts."""
        self._last.update(lasts)

    def enter(self, key: str, robot_id: str, *, may_replay: bool) -> asyncio.Queue[dict[str, Any]]:
        """Let a page in; what it is told comes by the queue that is returned."""
        before = self.viewers.get(key)
        if self._ear is not None:
            self._ear.look(self._clock.mono_s())
        viewer = Viewer(key, robot_id, may_replay)
        if before is not None and before.client is not None:
            before.show_replay(None)
            viewer.join(before.client)
        self.viewers[key] = viewer
        box: asyncio.Queue[dict[str, Any]] = asyncio.Queue(maxsize=64)
        self._boxes[key] = box
        self._join_waiting(viewer)
        return box

    def leave(self, key: str, box: asyncio.Queue[dict[str, Any]]) -> None:
        """A page went; a newer one with the same key stays."""
        if self._boxes.get(key) is not box:
            return
        viewer = self.viewers.pop(key)
        viewer.show_replay(None)
        del self._boxes[key]
        for robot_id in [one for one in self._sites if one not in self._watched()]:
            self._sites.pop(robot_id).remove()
        for robot_id in [one for one in self.world.robots() if self.posture(one) is None]:
            self.world.remove(robot_id)  # drawn by what the console heard before, for those who looked

    def obey(self, key: str, order: orders.Order) -> None:
        """Do what a page asks of its own picture."""
        viewer = self.viewers.get(key)
        if viewer is None:
            return
        match order:
            case orders.SetView():
                self._aim(viewer, order.view)
            case orders.SetLayer():
                viewer.set_layer(order.name, is_on=order.on)
            case orders.Hold():
                viewer.hold(is_held=order.on, now_s=self._clock.mono_s())
            case orders.Zoom():
                viewer.zoom(order.by)
            case orders.Replay() if viewer.may_replay:
                self._replay(viewer, order)
            case orders.Live():
                self._replay(viewer, None)
            case orders.Unmark():
                viewer.mark(None, None)
            case orders.Lift():
                viewer.lift(order.height_m)
            case orders.Theme():
                viewer.set_dark(is_dark=order.dark)
            case _:
                pass

    async def _run(self) -> None:
        while True:
            began_s = self._clock.mono_s()
            try:
                self.attend()
                if any(viewer.client is not None for viewer in self.viewers.values()):
                    self.tick()
            except Exception:  # one bad picture must not end all others
                log.exception("drawing failed")
            await asyncio.sleep(max(0.01, TICK_S - (self._clock.mono_s() - began_s)))

    def attend(self) -> None:
        """Listen while somebody looks; what was heard is forgotten with the last who did, for it gets old unseen."""
        if self._ear is None:
            return
        now_s = self._clock.mono_s()
        if self.viewers:
            self._ear.look(now_s)
        elif self._ear.rest(now_s):
            self.intake.forget(but=())
            for robot_id in self.world.robots():
                self.world.remove(robot_id)

    def tick(self) -> None:
        """Draw once."""
        self._round += 1
        watched = self._watched()
        with self.world.at_once():
            for robot_id in self.farm:
                self._draw(robot_id, is_watched=robot_id in watched)
            if self._round % DETAILS_EVERY == 0:
                for robot_id in watched:
                    self._details(robot_id)
        now_s = self._clock.mono_s()
        for viewer in self.viewers.values():
            recall(self, viewer)
            place = self.base(viewer)
            if viewer.client is not None and not viewer.is_aimed:
                self._aim(viewer, viewer.view)  # its robot was not heard yet when it came
            if place is not None:
                viewer.follow(place.xyz, now_s)
        if self._round % STATUS_EVERY == 0:
            self._tell_all(now_s)
            self.world.beat()

    def posture(self, robot_id: str) -> Posture | None:
        """Return where a robot is in the site's plane, ``None`` before anybody knew."""
        return posture_of(self, robot_id)

    def last(self, robot_id: str) -> Last | None:
        """Return what the console heard of a robot before somebody looked at any."""
        return self._last.get(robot_id) if self.viewers else None

    def _draw(self, robot_id: str, *, is_watched: bool) -> None:
        posture = self.posture(robot_id)
        factsheet = self.intake.newest(robot_id, Up.FACTSHEET, up.Factsheet)
        if posture is None or factsheet is None:
            return
        form, now_s = self.library.form(factsheet[0]), self._clock.mono_s()
        self.world.show(robot_id, form, posture, now_s, has_ghost=is_watched)

    def _details(self, robot_id: str) -> None:
        form, posture = self.world.form_of(robot_id), self.posture(robot_id)
        factsheet = self.intake.newest(robot_id, Up.FACTSHEET, up.Factsheet)
        if form is None or posture is None or factsheet is None:
            return
        site = self._sites.get(robot_id)
        if site is None:
            site = self._sites[robot_id] = SiteView(self.server.scene, self.world.mover, robot_id)
            site.set_plan(self._plans.get(robot_id, Plan()), self.frame)
        datum = factsheet[0].datum
        site.frusta.fade(self._clock.mono_s())
        site.show(
            shift=self.frame.shift(datum.lat_deg, datum.lon_deg),
            posture=posture,
            form=form,
            factsheet=factsheet[0],
            keep_out_m=self.keep_out_m(robot_id, factsheet[0]),
            body=_message(self.intake.newest(robot_id, Up.BODY, machine.Body)),
            worksite=_message(self.intake.newest(robot_id, Up.WORKSITE, machine.Worksite)),
            scan=_message(self.intake.newest(robot_id, Up.SCAN, machine.Scan)),
            order=_order(self.intake.newest(robot_id, Up.STATE, up.State)),
            now_ms=round(self._clock.utc().timestamp() * 1000),
        )

    def keep_out_m(self, robot_id: str, factsheet: up.Factsheet) -> float:
        """Return how far people must stay away."""
        known = self.farm.get(robot_id)
        told = factsheet.behaviour or up.Behaviour()
        return keep_out_m(None if known is None else known.keep_out_m, told.keep_out_m)

    def site(self, robot_id: str) -> SiteView | None:
        """Return what is drawn around a watched robot."""
        return self._sites.get(robot_id)

    def base(self, viewer: Viewer) -> Place | None:
        """Return where a viewer's robot is in its picture: now, or at the moment it replays."""
        solid = self.world.solid(viewer.robot_id)
        if solid is None:
            return None
        return self.world.mover.place(solid.name) if viewer.past is None else viewer.past.body

    def _aim(self, viewer: Viewer, view: View) -> None:
        base, form = self.base(viewer), self.world.form_of(viewer.robot_id)
        posture = self.posture(viewer.robot_id)
        if base is None or form is None or posture is None:
            viewer.view = view
            return
        head = form.head(base, posture.joints) if viewer.past is None else viewer.past.head
        viewer.aim(view, base, form.size_m, head, self._clock.mono_s())

    def _replay(self, viewer: Viewer, moment: Moment | None) -> None:
        was_past, viewer.moment = viewer.past is not None, moment
        if moment is None:
            viewer.show_replay(None)
        recall(self, viewer)
        if was_past != (viewer.past is not None):  # the page waits for it
            self._tell(viewer.key, status_of(self, viewer, self._clock.mono_s()))

    def _tell_all(self, now_s: float) -> None:
        for key, viewer in self.viewers.items():
            self._mark_again(viewer)
            self._tell(key, status_of(self, viewer, now_s))

    def _mark_again(self, viewer: Viewer) -> None:
        """Let the mark stay with a robot that was touched, and its line with the one that is watched."""
        base, touched = self.base(viewer), viewer.touched_robot
        place = None if touched is None else base_of(self, viewer, touched)
        if place is not None:
            viewer.mark_at(place.xyz[:2])
        if base is not None and touched != viewer.robot_id:
            viewer.mark_from(base.xyz)

    def _tell(self, key: str, message: dict[str, Any]) -> None:
        box = self._boxes.get(key)
        if box is not None and not box.full():  # a page that takes nothing misses what is old by then
            box.put_nowait(message)

    def _watched(self) -> set[str]:
        return {viewer.robot_id for viewer in self.viewers.values()}

    def _connected(self, client: viser.ClientHandle) -> None:
        if self._loop is not None:
            self._loop.call_soon_threadsafe(self._joined, client)

    def _disconnected(self, client: viser.ClientHandle) -> None:
        if self._loop is not None and not self._loop.is_closed():
            self._loop.call_soon_threadsafe(self._left, client.client_id)

    def _joined(self, client: viser.ClientHandle) -> None:
        headers = headers_of(self.server, client.client_id)
        key = "" if headers is None else headers.get(VIEWER_HEADER, "")
        viewer = self.viewers.get(key)
        if viewer is None:
            return
        viewer.join(client)
        self.tick()
        self._aim(viewer, viewer.view)
        client.scene.remove_click_callback("all")  # a page that came back has one from before
        client.scene.on_click()(lambda event: self._clicked(key, event))

    def _join_waiting(self, viewer: Viewer) -> None:
        """The picture may be there before the page's wishes."""
        if viewer.client is not None:
            return
        for client_id, client in self.server.get_clients().items():
            headers = headers_of(self.server, client_id)
            if headers is not None and headers.get(VIEWER_HEADER) == viewer.key:
                self._joined(client)

    def _left(self, client_id: int) -> None:
        for viewer in self.viewers.values():
            viewer.leave(client_id)

    def _clicked(self, key: str, event: Any) -> None:
        if self._loop is not None:
            self._loop.call_soon_threadsafe(self.touch, key, event.ray_origin, event.ray_direction)

    def touch(self, key: str, origin: tuple[float, float, float], direction: tuple[float, float, float]) -> None:
        """Tell a page what lies under a ray in the site's plane, and mark the place."""
        viewer = self.viewers.get(key)
        if viewer is not None and all(map(math.isfinite, (*origin, *direction))):
            place, said = tapped(self, viewer, origin, direction)
            robot_id = said["id"] if said["what"] == "robot" else None
            base = None if robot_id == viewer.robot_id else self.base(viewer)
            viewer.mark(place, None if base is None else base.xyz, robot_id)
            self._tell(key, said)


def _message(heard: tuple[Any, float] | None) -> Any:
    return None if heard is None else heard[0]


def _order(heard: tuple[up.State, float] | None) -> up.OrderState | None:
    return None if heard is None else heard[0].order


def layers_by_name() -> Mapping[str, Group]:
    """Return the layers by the names pages use."""
    return {group.value: group for group in Group}
