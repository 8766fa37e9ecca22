"""What a page is told twice a second of the picture it shows: ages, counts, model."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from backend_clients.edge import machine
from backend_clients.edge import messages_up as up
from backend_clients.edge.topics import Up
from hmi.media.tap import where_is
from hmi.media.whereabouts import limbs_of

if TYPE_CHECKING:
    from hmi.media.studio import Studio
    from hmi.twin.viewer import Viewer


def status_of(studio: Studio, viewer: Viewer, now_s: float) -> dict[str, Any]:
    """Return ages in seconds (``None``: not known) and counts of the layers; ``unheard`` are joints drawn at rest."""
    robot_id = viewer.robot_id
    intake = studio.intake
    factsheet = intake.newest(robot_id, Up.FACTSHEET, up.Factsheet)
    pose = intake.newest(robot_id, Up.TELEMETRY, up.Telemetry)
    body = intake.newest(robot_id, Up.BODY, machine.Body)
    scan = intake.newest(robot_id, Up.SCAN, machine.Scan)
    site, drawn_s = studio.site(robot_id), studio.world.drawn_at_s(robot_id)
    has_joints = factsheet is not None and bool(factsheet[0].joints)
    limbs = limbs_of(studio, robot_id)
    limbs_s = limbs.at_s if limbs is not None else None if has_joints or pose is None else pose[1]
    planned = body if body is not None and body[0].planned else None
    return {
        "k": "status",
        "robot": robot_id,
        "is_drawn": studio.world.solid(robot_id) is not None,
        "model": "" if factsheet is None else studio.library.kind_of(factsheet[0]),
        "pose_age_s": None if drawn_s is None else _rounded(now_s - drawn_s),
        "unheard": list(studio.world.unheard(robot_id)),
        "ages_s": {
            "machine": None if limbs_s is None else _rounded(now_s - limbs_s),
            "planned": _age(planned, now_s),
            "scan": _age(scan, now_s),
            "cameras": _rounded(None if site is None else site.frusta.age_s(now_s)),
        },
        "joints": [] if factsheet is None else [joint.name for joint in factsheet[0].joints],
        "has_scan": scan is not None,
        "cameras": 0 if site is None else len(site.frusta.cameras),
        "trees": None if site is None else _trees(site.surface),
        "trail": 0 if site is None else site.trail.points,
        "keep_out_m": None if factsheet is None else studio.keep_out_m(robot_id, factsheet[0]),
        "reach_m": None if site is None or site.reach is None else round(site.reach.radius_m, 2),
        "touched": None if viewer.touched is None else where_is(studio, viewer, viewer.touched),
        "is_past": viewer.past is not None,
        "past_unheard": [] if viewer.past is None else sorted(viewer.past.basis.doubt.joints),
        "past_ms": None if viewer.past is None else viewer.past.basis.moment.at_ms,
        "view": viewer.view.value,
        "is_connected": viewer.client is not None,
    }


def _trees(surface: Any) -> dict[str, int] | None:
    if surface.site is None and not surface.done and not surface.failed:
        return None
    targets = [] if surface.site is None else surface.site.targets
    waiting = sum(1 for target in targets if target.status in ("planned", "current"))
    return {"done": surface.done, "failed": surface.failed, "here": waiting}


def _age(heard: tuple[Any, float] | None, now_s: float) -> float | None:
    return None if heard is None else _rounded(now_s - heard[1])


def _rounded(age_s: float | None) -> float | None:
    return None if age_s is None else round(max(0.0, age_s), 2)
