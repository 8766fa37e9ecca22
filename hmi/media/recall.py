"""Shows a viewer the recorded moment it asked for; one whose robot is not drawn yet waits for it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from backend_clients.edge import messages_up as up
from backend_clients.edge.topics import Up
from hmi.media.whereabouts import tells_height, unheard_of
from hmi.twin.doubt import EVERYTHING, NOTHING, Doubt
from hmi.twin.kinematics import Place
from hmi.twin.moment import Moment
from hmi.twin.past import Basis, past_of
from hmi.twin.rotation import yaw

if TYPE_CHECKING:
    from hmi.media.studio import Studio
    from hmi.twin.viewer import Viewer


def recall(studio: Studio, viewer: Viewer) -> None:
    """Bring a replay up to date: with its moment, and with what of now must not be seen beside it."""
    moment, drawn = viewer.moment, studio.world.solid(viewer.robot_id)
    if moment is None or drawn is None:
        return
    site, before = studio.site(viewer.robot_id), viewer.past
    others = tuple(robot_id for robot_id in studio.farm if robot_id != viewer.robot_id)
    ends = 0 if site is None else site.surface.ends
    basis = Basis(moment, drawn, ends, others, _doubt(studio, viewer.robot_id, moment), drawn.doubted)
    if before is not None and before.basis == basis:
        return
    undone = frozenset(moment.undone)
    if site is not None and moment.at_ms is not None:
        undone |= site.surface.ended_after(moment.at_ms)
    if before is not None and (before.undone, before.basis.ends) == (undone, basis.ends):
        marks = before.marks
    else:
        marks = {} if site is None else site.surface.without(undone)
    if before is not None and before.basis.drawn is not drawn:
        viewer.show_replay(None)  # another model has other frames
    east, north = studio.frame.local(moment.lat_deg, moment.lon_deg)
    body = Place((east, north, moment.height_m or 0.0), yaw(moment.theta_rad))
    viewer.show_replay(past_of(viewer.robot_id, basis, body, undone, marks))


def _doubt(studio: Studio, robot_id: str, moment: Moment) -> Doubt:
    """What the record does not tell of that moment."""
    heard = studio.intake.newest(robot_id, Up.FACTSHEET, up.Factsheet)
    if heard is None:
        return NOTHING
    if moment.height_m is None and tells_height(heard[0]):
        return EVERYTHING
    return Doubt(joints=frozenset(unheard_of(studio, heard[0], moment.joints)))
