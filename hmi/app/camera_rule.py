"""What the camera process may open: the robots' own cameras, others where an admin said so, and field cameras."""

from __future__ import annotations

from dataclasses import replace
from urllib.parse import urlsplit

from hmi.commands.camera_source_book import CameraSourceBook
from hmi.domain.camera import CameraInfo, Source, SourceKind
from hmi.domain.camera_source import FIELD, Reach
from hmi.store.camera_sources import StoredSource

UNKNOWN_PX = 640, 480  # before the first picture came
LOOPBACK = ("127.0.0.0/8", "::1/128")


class CameraRule:
    """Called with the robots' own sources; returns what is really opened."""

    def __init__(self, book: CameraSourceBook) -> None:
        self._book = book

    def __call__(self, own: list[Source]) -> list[Source]:
        """See ``hmi.app.camera_sources.SourceRule``."""
        named = {(one.robot, one.camera.id) for one in own}
        added = [one for one in self._book.robot_cameras() if (one.robot_id, one.camera) not in named]
        cameras = [*own, *(Source(one.robot_id, bare_camera(one)) for one in added)]
        return [self._set(one) for one in cameras] + [self._field(one) for one in self._book.field_cameras()]

    def _set(self, own: Source) -> Source:
        wanted = self._book.source_of(own.robot, own.camera.id)
        if wanted is None:
            return own
        return replace(
            own, kind=wanted.kind, url=wanted.url, token="", user=wanted.user, password=wanted.password,
            nets=nets_of(self._book.reach(own.robot), wanted.url), is_on=True,
            period_s=_period_s(self._book.stored(own.robot, own.camera.id)),
        )  # fmt: skip

    def _field(self, one: StoredSource) -> Source:
        camera = bare_camera(one)
        if one.kind is SourceKind.UPLOAD:
            return Source(FIELD, camera, one.kind, period_s=one.period_s)
        wanted = self._book.source_of(FIELD, one.camera)
        password = "" if wanted is None else wanted.password
        nets = nets_of(self._book.reach(FIELD), one.url)
        return Source(FIELD, camera, one.kind, one.url, user=one.user_name, password=password, nets=nets,
                      period_s=_period_s(one))  # fmt: skip


def bare_camera(one: StoredSource) -> CameraInfo:
    """Return what is known of a camera that no robot tells of."""
    wide, high = (one.width_px, one.height_px) if one.width_px else UNKNOWN_PX
    return CameraInfo(one.camera, one.label or one.camera, wide, high)


def _period_s(one: StoredSource | None) -> float | None:
    """Return how far apart pictures are meant to come, ``None`` where the stream itself says so."""
    return one.period_s if one is not None and one.kind is SourceKind.SNAPSHOT else None


def nets_of(reach: Reach, url: str) -> tuple[str, ...]:
    """Return where a source's host may lead to; empty for the robot itself, which is where it is registered.

    Of no network at all nothing may be opened: then it is one without any machine in it.
    """
    host = urlsplit(url).hostname or ""
    if reach.names(host):
        return ()
    nets = tuple(str(one) for one in reach.networks) + (LOOPBACK if reach.is_loopback_allowed else ())
    return nets or ("192.0.2.0/32",)
