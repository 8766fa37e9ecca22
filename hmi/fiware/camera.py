"""Camera (CrossSector): one camera of a robot or a field."""

from __future__ import annotations

from hmi.domain.camera import CameraInfo
from hmi.fiware.urn import OWN, KeyValues, Urns, point, told


def camera_entity(
    urns: Urns,
    owner_id: str,
    camera: CameraInfo,
    name: str,
    *,
    is_on: bool | None = None,
    place: tuple[float, float] | None = None,
) -> KeyValues:
    """Return a camera. Its pictures stay where they are: no address of any goes up.

    Args:
        owner_id: robot it is on, or the name for cameras of the field.
        is_on: its robot is heard; ``None`` for a camera that nobody asks.
        place: latitude and longitude in degrees, where it does not move.
    """
    can_turn = camera.ptz is not None and bool(camera.ptz.pan or camera.ptz.tilt)
    return told(
        {
            "id": urns.of("Camera", f"{owner_id}:{camera.id}"),
            "type": "Camera",
            "cameraName": name,
            "cameraType": "PTZ" if can_turn else "FIXED",
            "cameraUsage": "SURVEILLANCE",
            "on": is_on,
            "location": None if place is None else point(*place),
            OWN: told(
                {
                    "owner": owner_id,
                    "kind": camera.kind,
                    "view": camera.view,
                    "widthPx": camera.width_px,
                    "heightPx": camera.height_px,
                    "framesPerSecond": camera.fps,
                    "fieldOfViewDeg": camera.fov_deg,
                }
            ),
        }
    )


def camera_off(entity: KeyValues) -> KeyValues:
    """Return what is told of a camera that is there no more."""
    return {"id": entity["id"], "type": "Camera", "on": False}
