"""Cameras: what one is, where its pictures come from, and how it does. Pure values, shared by console and process."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import StrEnum

FIELD_ROBOT = "field"  # the robot name of cameras that belong to no robot
FROZEN_S = 1.0  # no new picture for so long from 2 fps on
FROZEN_PERIODS = 3  # below 2 fps


class SourceKind(StrEnum):
    """How pictures are fetched."""

    ROBOT = "robot"
    RTSP = "rtsp"
    WHEP = "whep"
    MJPEG = "mjpeg"
    SNAPSHOT = "snapshot"
    UPLOAD = "upload"


class CameraState(StrEnum):
    """How a camera does; see ``docs/protocols/cameras.md``."""

    IDLE = "idle"
    STARTING = "starting"
    LIVE = "live"
    FROZEN = "frozen"
    FAILED = "failed"
    OFF = "off"


@dataclass(frozen=True, slots=True)
class CameraPtz:
    """What turns it: names of joints, and the smallest and largest zoom."""

    pan: str | None = None
    tilt: str | None = None
    zoom: tuple[float, float] | None = None


@dataclass(frozen=True, slots=True)
class CameraInfo:
    """A camera as its factsheet describes it; ``fov_deg`` is horizontal."""

    id: str
    label: str
    width_px: int
    height_px: int
    kind: str = "colour"
    fps: float = 15.0
    view: str = "front"
    fov_deg: float | None = None
    ptz: CameraPtz | None = None
    has_lamp: bool = False
    has_trigger: bool = False


@dataclass(frozen=True, slots=True)
class Source:
    """Where the pictures of one camera come from. Made by the console, opened by the camera process.

    ``url`` is the robot's HTTP address for ``robot``, else that of the stream. ``token`` is a bearer token; for
    ``upload`` the one its camera must show. ``nets``: networks an address may lie in once its name is resolved;
    empty if the console checked it. ``is_on``: the robot is connected. ``period_s``: how far apart pictures are meant
    to come where that is not ``1 / fps``.
    """

    robot: str
    camera: CameraInfo
    kind: SourceKind = SourceKind.ROBOT
    url: str = ""
    token: str = field(default="", repr=False)
    user: str = field(default="", repr=False)
    password: str = field(default="", repr=False)
    nets: tuple[str, ...] = ()
    is_on: bool = True
    period_s: float | None = None

    @property
    def name(self) -> str:
        """``robot/camera``."""
        return f"{self.robot}/{self.camera.id}"

    @property
    def place(self) -> str:
        """Where its pictures come from, in one word: those of two places are never pictures of one camera."""
        return f"{self.kind.value} {self.url}"

    @property
    def expected_period_s(self) -> float:
        """Seconds between two pictures when all is well."""
        return self.period_s if self.period_s is not None else 1.0 / self.camera.fps


@dataclass(frozen=True, slots=True)
class Recording:
    """A camera whose last minute is kept; upper limits of what is pulled for that alone."""

    robot: str
    camera: str
    fps: float = 5.0
    width: int = 640


def frozen_after_s(period_s: float) -> float:
    """Return after how long without a new picture a stream counts as frozen."""
    return FROZEN_S if period_s <= 0.5 else FROZEN_PERIODS * period_s


@dataclass(frozen=True, slots=True)
class CameraSetting:
    """How a robot says its camera is set; ``None`` is by itself or not known."""

    lamp: bool | None = None
    zoom: float | None = None


class ControlFailed(Exception):
    """A robot's camera did not do as told; ``text`` says why, for a person."""

    def __init__(self, code: str, text: str) -> None:
        super().__init__(text)
        self.code, self.text = code, text
