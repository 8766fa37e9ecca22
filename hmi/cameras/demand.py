"""What those who look want, and what the worker must make of it."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from enum import StrEnum

from hmi.cameras.picture_wire import JpegWish, Plan
from hmi.domain.camera import CameraInfo

WIDTHS = (160, 320, 480, 640, 960, 1280, 1920)  # few sizes, so that few are encoded
MOST_FPS = 30.0


class Way(StrEnum):
    """How pictures travel."""

    H264 = "h264"
    VP8 = "vp8"
    JPEG = "jpeg"


@dataclass(frozen=True, slots=True)
class Wish:
    """One who looks: at most this width (0: as it comes) and so many pictures a second."""

    way: Way
    width: int = 0
    fps: float = MOST_FPS


def step_of(width: int, camera: CameraInfo) -> int:
    """Return the width that is made for somebody who wants ``width``: a step above it, 0 for the picture as it is."""
    if width <= 0 or width >= camera.width_px:
        return 0
    above = next((one for one in WIDTHS if one >= width), 0)
    return above if above < camera.width_px else 0


def plan_of(wishes: Iterable[Wish], camera: CameraInfo, video_width: int) -> Plan:
    """Return the least that satisfies everybody.

    Args:
        video_width: the most that is encoded for WebRTC, whatever is wished.
    """
    wishes = list(wishes)
    jpegs: dict[int, float] = {}
    widths: list[int] = []
    videos: list[int] = []
    for wish in wishes:
        if wish.way is Way.JPEG:
            step = step_of(wish.width, camera)
            jpegs[step] = max(jpegs.get(step, 0.0), wish.fps)
            widths.append(step)
        else:
            step = step_of(min(wish.width or video_width, video_width), camera)
            widths.append(step)
            videos.append(min(step or video_width, video_width))
    return Plan(
        fps=round(min(camera.fps, max((wish.fps for wish in wishes), default=1.0)), 2),
        width=0 if 0 in widths or not widths else max(widths),
        has_h264=any(wish.way is Way.H264 for wish in wishes),
        has_vp8=any(wish.way is Way.VP8 for wish in wishes),
        video_width=max(videos, default=video_width),
        jpegs=tuple(JpegWish(width, jpegs[width]) for width in sorted(jpegs)),
    )
