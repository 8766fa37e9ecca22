"""Pictures of cameras for the scene: which are wanted, and how one that comes is made small."""

from __future__ import annotations

import io
from typing import TYPE_CHECKING

import numpy as np

from hmi.domain.picture_header import BadPicture, read_picture
from hmi.twin.frusta import Pixels
from hmi.twin.groups import Group

if TYPE_CHECKING:
    from hmi.media.studio import Studio

MAX_BYTES = 4 * 1024 * 1024
MOST_PIXELS = 12_000_000
SIZE_PX = (320, 320)  # a picture in the scene is a few centimetres on the screen


def small(data: bytes) -> Pixels:
    """Return a JPEG or PNG as (height, width, 3), at most 320 px wide and high; blocking.

    Raises:
        BadPicture: it is none, is too large or cannot be decoded.
    """
    from PIL import Image  # while nobody shows cameras nothing decodes

    read_picture(data, MOST_PIXELS)
    try:
        with Image.open(io.BytesIO(data), formats=("JPEG", "PNG")) as picture:
            picture.draft("RGB", SIZE_PX)  # a JPEG is decoded at an eighth of its size where that is enough
            made = picture.convert("RGB")
            made.thumbnail(SIZE_PX)
    except (OSError, SyntaxError, ValueError) as error:
        raise BadPicture("not_a_picture", "This picture cannot be decoded.") from error
    return np.asarray(made, dtype=np.uint8)


def wanted(studio: Studio) -> dict[str, list[str]]:
    """Return the cameras somebody looks through, by robot: their layer is shown in an open picture."""
    found: dict[str, list[str]] = {}
    for viewer in studio.viewers.values():
        site = studio.site(viewer.robot_id)
        if viewer.client is not None and Group.CAMERAS not in viewer.hidden and site is not None:
            found[viewer.robot_id] = site.frusta.cameras
    return {robot_id: cameras for robot_id, cameras in found.items() if cameras}
