"""Where each camera's pictures come from: by default its robot, else what an admin set. Kept in memory and on disk."""

from __future__ import annotations

import asyncio
import hashlib
import secrets
import socket
from collections.abc import Awaitable, Callable, Sequence
from dataclasses import dataclass, replace

from hmi.clock import Clock
from hmi.commands.audit_line import audit_line
from hmi.commands.camera_ports import CameraProcess, CamerasAway, NoPicture
from hmi.commands.ports import AuditSink
from hmi.domain.camera import SourceKind
from hmi.domain.camera_source import (
    FIELD,
    Reach,
    Source,
    SourceRefused,
    check_url,
    pin,
    reach_of,
)
from hmi.domain.picture_header import BadPicture, read_picture
from hmi.domain.role import Permission
from hmi.security.authorization import Authorize
from hmi.security.sealed import Seal
from hmi.security.session_info import SessionInfo
from hmi.store.camera_sources import CameraSources, StoredSource
from hmi.store.database import Database
from hmi.store.errors import NotFound

MOST_FIELD_CAMERAS = 32
PULLED = (SourceKind.RTSP, SourceKind.WHEP, SourceKind.MJPEG, SourceKind.SNAPSHOT)
UPLOAD_PERIOD_S = 5.0
SNAPSHOT_PERIOD_S = 0.5  # the rarest that counts as a stream: no new picture for a second, and it is frozen
Resolve = Callable[[str, int], Sequence[str]]
Key = tuple[str, str]


@dataclass(frozen=True, slots=True)
class SourceWish:
    """What an admin wants. ``None`` keeps what is there, an empty text removes it."""

    kind: SourceKind
    url: str = ""
    user: str = ""
    password: str | None = None
    label: str | None = None
    period_s: float | None = None
    keep_every_s: float | None = None
    is_new_token: bool = False


@dataclass(frozen=True, slots=True)
class Verdict:
    """How a test went: one sentence, and the picture's size if one came."""

    is_ok: bool
    text: str
    width_px: int = 0
    height_px: int = 0
    took_s: float = 0.0


@dataclass(frozen=True, slots=True)
class SourceParts:
    """What the book is wired to.

    Attributes:
        robot_url: HTTP address a robot is registered with, ``None`` if it has none.
        is_known: whether a robot is registered.
        forget_frames: drops the newest frame of a field camera.
        networks: where cameras may be besides.
        resolve: host and port to addresses; blocking.
    """

    records: CameraSources
    database: Database
    seal: Seal
    process: CameraProcess
    authorize: Authorize
    audit: AuditSink
    clock: Clock
    robot_url: Callable[[str], str | None]
    is_known: Callable[[str], bool]
    forget_frames: Callable[[str], Awaitable[None]]
    networks: tuple[str, ...] = ()
    is_demo: bool = False
    resolve: Resolve | None = None


class CameraSourceBook:
    """Answers everything about sources; those for programs come from memory.

    Raises (methods with a session): ``NotSignedIn``, ``NotAllowed``, ``StoreError`` and what they name themselves.
    """

    def __init__(self, parts: SourceParts) -> None:
        self._parts = parts
        self._known: dict[Key, StoredSource] = {}
        self._changing = asyncio.Lock()
        self.on_changed: list[Callable[[], None]] = []

    async def load(self) -> None:
        """Read what is kept; at start."""
        every = await self._parts.database.run(self._parts.records.all)
        self._known = {(one.robot_id, one.camera): one for one in every}

    # ---- for programs ----

    def source_of(self, robot_id: str, camera: str) -> Source | None:
        """Return where a camera's pictures come from if not from its robot, with its password; never on the wire."""
        one = self._known.get((robot_id, camera))
        if one is None:
            return None
        return Source(robot_id, camera, one.kind, one.url, one.user_name, self._parts.seal.open(one.sealed) or "")

    def field_cameras(self) -> list[StoredSource]:
        """Return the cameras that belong to no robot, by name."""
        return sorted((one for (robot, _), one in self._known.items() if robot == FIELD), key=lambda one: one.camera)

    def robot_cameras(self) -> list[StoredSource]:
        """Return what is set for cameras of robots that are registered, by name."""
        known = self._parts.is_known
        return sorted((one for (robot, _), one in self._known.items() if robot != FIELD and known(robot)),
                      key=lambda one: (one.robot_id, one.camera))  # fmt: skip

    def stored(self, robot_id: str, camera: str) -> StoredSource | None:
        """Return what is kept of a camera."""
        return self._known.get((robot_id, camera))

    def reach(self, robot_id: str) -> Reach:
        """Return where the cameras of a robot may be."""
        parts = self._parts
        url = None if robot_id == FIELD else parts.robot_url(robot_id)
        return reach_of(parts.networks, url, is_demo=parts.is_demo)

    async def noted_size(self, one: StoredSource, width_px: int, height_px: int) -> None:
        """Note how large the pictures of an upload are."""
        key = one.robot_id, one.camera
        if key not in self._known or (one.width_px, one.height_px) == (width_px, height_px):
            return
        self._known[key] = replace(self._known[key], width_px=width_px, height_px=height_px)
        await self._parts.database.run(self._parts.records.set_size, *key, width_px, height_px)
        self._tell()

    async def welcome(self, camera: str, label: str, by: str, period_s: float) -> None:
        """Let a field camera send its pictures by the broker; one that is set already stays as it is.

        Raises:
            SourceRefused: there are too many.
        """
        async with self._changing:
            if (FIELD, camera) in self._known:
                return
            if len(self.field_cameras()) >= MOST_FIELD_CAMERAS:
                raise SourceRefused("too_many", f"A farm has {MOST_FIELD_CAMERAS} field cameras at most.")
            at = self._parts.clock.utc()
            made = StoredSource(FIELD, camera, SourceKind.UPLOAD, by, at, label=label, period_s=period_s)
            await self._parts.database.run(self._parts.records.put, made)
            self._known[FIELD, camera] = made
        self._tell()

    async def expect(self, camera: str, period_s: float) -> None:
        """Expect pictures of a field camera that came in by the broker so far apart; one that a person set stays."""
        async with self._changing:
            one = self._known.get((FIELD, camera))
            if one is None or one.kind is not SourceKind.UPLOAD or one.token_sha256 or one.period_s == period_s:
                return
            made = replace(one, period_s=period_s)
            await self._parts.database.run(self._parts.records.put, made)
            self._known[FIELD, camera] = made
        self._tell()

    async def dismiss(self, camera: str) -> None:
        """Forget a field camera that came in by the broker; one with a token of its own stays."""
        async with self._changing:
            one = self._known.get((FIELD, camera))
            if one is None or one.kind is not SourceKind.UPLOAD or one.token_sha256:
                return
            await self._parts.database.run(self._parts.records.remove, FIELD, camera)
            self._known.pop((FIELD, camera), None)
        await self._parts.forget_frames(camera)
        self._tell()

    # ---- for people ----

    def all(self, session: SessionInfo) -> list[StoredSource]:
        """Return every source that is set."""
        self._parts.authorize(session, Permission.MANAGE_CAMERAS)
        return sorted(self._known.values(), key=lambda one: (one.robot_id, one.camera))

    def get(self, session: SessionInfo, robot_id: str, camera: str) -> StoredSource | None:
        """Return what is set for a camera, ``None``: its robot."""
        self._may(session, robot_id)
        return self._known.get((robot_id, camera))

    async def put(self, session: SessionInfo, robot_id: str, camera: str, wish: SourceWish) -> tuple[StoredSource, str]:
        """Set where a camera's pictures come from; return it and a new upload token, empty if there is none.

        Raises:
            SourceRefused: the address is not used.
        """
        self._may(session, robot_id)
        async with self._changing:
            before = self._known.get((robot_id, camera))
            if before is None and robot_id == FIELD and len(self.field_cameras()) >= MOST_FIELD_CAMERAS:
                raise SourceRefused("too_many", f"A farm has {MOST_FIELD_CAMERAS} field cameras at most.")
            made, token = self._made(session, robot_id, camera, wish, before)
            await self._parts.database.run(self._parts.records.put, made)
            self._known[(robot_id, camera)] = made
        self._tell()
        where = made.url.partition("?")[0] or "sent by HTTP"
        self._note(
            session, "changed", f"Pictures of {robot_id}, {camera}: {made.kind.value}, {where}.", robot_id, camera
        )
        return made, token

    async def remove(self, session: SessionInfo, robot_id: str, camera: str) -> None:
        """Take the pictures from the robot again, or forget a field camera; raises ``NotFound``."""
        self._may(session, robot_id)
        async with self._changing:
            if not await self._parts.database.run(self._parts.records.remove, robot_id, camera):
                raise NotFound(f"{robot_id}/{camera} has no source of its own")
            self._known.pop((robot_id, camera), None)
        if robot_id == FIELD:
            await self._parts.forget_frames(camera)
        self._tell()
        self._note(session, "removed", f"Pictures of {robot_id}, {camera}: its own source is gone.", robot_id, camera)

    async def test(self, session: SessionInfo, robot_id: str, camera: str) -> Verdict:
        """Ask for one picture from where it should come from; says what stands in the way."""
        self._may(session, robot_id)
        one, began_s = self._known.get((robot_id, camera)), self._parts.clock.mono_s()
        if one is not None and one.kind is SourceKind.UPLOAD:
            return Verdict(False, "This camera sends its pictures by itself. Wait for the next one.")
        try:
            if one is not None:
                await self._found(one)
            still = await self._parts.process.still(robot_id, camera, 1.0)
            header = read_picture(still.data)
        except (SourceRefused, NoPicture, BadPicture) as error:
            return Verdict(False, error.text, took_s=self._parts.clock.mono_s() - began_s)
        except CamerasAway:
            return Verdict(False, "The camera process does not answer. It comes back by itself; try again.")
        text = f"A picture came, {header.width_px} x {header.height_px}."
        return Verdict(True, text, header.width_px, header.height_px, self._parts.clock.mono_s() - began_s)

    async def _found(self, one: StoredSource) -> None:
        """Resolve the host and judge it, as whoever fetches does; raises ``SourceRefused``."""
        reach = self.reach(one.robot_id)
        place = check_url(one.kind, one.url, reach)
        try:
            addresses = await asyncio.to_thread(self._parts.resolve or _resolve, place.host, place.port)
        except (OSError, UnicodeError) as error:
            raise SourceRefused("no_address", f"{place.host} cannot be found.") from error
        pin(place, addresses, reach)

    def _made(
        self, session: SessionInfo, robot_id: str, camera: str, wish: SourceWish, before: StoredSource | None
    ) -> tuple[StoredSource, str]:
        parts, at = self._parts, self._parts.clock.utc()
        base = before or StoredSource(robot_id, camera, wish.kind, session.user_name, at, label=camera)
        base = replace(
            base, kind=wish.kind, changed_by=session.user_name, changed_at=at,
            label=base.label if wish.label is None else wish.label,
            period_s=_period_s(wish, before),
            keep_every_s=base.keep_every_s if wish.keep_every_s is None else wish.keep_every_s,
        )  # fmt: skip
        if wish.kind is SourceKind.UPLOAD:
            return self._upload(base, wish)
        if wish.kind not in PULLED:
            raise SourceRefused("kind", "Delete the source instead: then the pictures come from the robot.")
        check_url(wish.kind, wish.url, self.reach(robot_id))
        sealed = parts.seal.seal(wish.password) if wish.password is not None else self._password(before, wish)
        return replace(base, url=wish.url, user_name=wish.user, sealed=sealed, token_sha256=""), ""

    def _password(self, before: StoredSource | None, wish: SourceWish) -> str:
        """Keep the password only where it goes to the same place: nobody may have it sent elsewhere unseen."""
        if before is None or before.kind not in PULLED or before.user_name != wish.user:
            return ""
        reach = self.reach(before.robot_id)
        try:
            old, new = check_url(before.kind, before.url, reach), check_url(wish.kind, wish.url, reach)
        except SourceRefused:
            return ""
        is_same = (old.host, old.port, old.scheme) == (new.host, new.port, new.scheme)
        return before.sealed if is_same else ""

    @staticmethod
    def _upload(base: StoredSource, wish: SourceWish) -> tuple[StoredSource, str]:
        if base.robot_id != FIELD:
            raise SourceRefused("kind", "Only field cameras send their pictures by themselves.")
        made = replace(base, url="", user_name="", sealed="")
        if base.token_sha256 and not wish.is_new_token:
            return made, ""
        token = secrets.token_urlsafe(32)
        return replace(made, token_sha256=digest_of(token)), token

    def _may(self, session: SessionInfo, robot_id: str) -> None:
        self._parts.authorize(session, Permission.MANAGE_CAMERAS, None if robot_id == FIELD else robot_id)

    def _tell(self) -> None:
        for listener in tuple(self.on_changed):
            listener()

    def _note(self, session: SessionInfo, outcome: str, text: str, robot_id: str, camera: str) -> None:
        line = audit_line(
            session, "camera", outcome, text, ref=camera, robot_id=None if robot_id == FIELD else robot_id
        )
        self._parts.audit.append(line)


def _period_s(wish: SourceWish, before: StoredSource | None) -> float:
    if wish.period_s is not None:
        return wish.period_s
    if before is not None and before.kind is wish.kind:
        return before.period_s
    return SNAPSHOT_PERIOD_S if wish.kind is SourceKind.SNAPSHOT else UPLOAD_PERIOD_S


def digest_of(token: str) -> str:
    """Return what is kept of a token: 256 random bits need no salt."""
    return hashlib.sha256(token.encode()).hexdigest()


def _resolve(host: str, port: int) -> list[str]:
    return [str(one[4][0]) for one in socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)]
