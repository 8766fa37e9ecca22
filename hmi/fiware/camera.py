"""Camera (CrossSector): one camera of a robot or a field."""

from __future__ import annotations

from hmi.fiware.urn import KeyValues, Urns, point, told


def camera_entity(
    urns: Urns,
    owner_id: str,
    camera_id: str,
    name: str,
    *,
    place: tuple[float, float] | None = None,
    is_on: bool | None = None,
    snapshot_url: str = "",
) -> KeyValues:
    """Return a camera; ``place`` is latitude and longitude in degrees. A camera's picture stays where it is."""
    return told(
        {
            "id": urns.of("Camera", f"{owner_id}:{camera_id}"),
            "type": "Camera",
            "cameraName": name,
            "cameraUsage": "ROBOT",
            "on": is_on,
            "imageSnapshot": snapshot_url or None,
            "location": None if place is None else point(*place),
        }
    )
