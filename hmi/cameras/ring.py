"""The last minute of a camera: encoded pictures as they were sent, and one JPEG a second."""

from __future__ import annotations

import asyncio
import itertools
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass

from hmi.cameras.camera import Camera
from hmi.cameras.demand import Way, Wish
from hmi.cameras.picture_wire import Piece
from hmi.clock import Clock
from hmi.domain.camera import Recording

KEPT_S = 110.0  # a clip holds a minute before what happened and up to 45 s after its beginning
KEPT_BYTES = 64 * 1024 * 1024
AFTERWARDS_S = 60.0  # so long a ring that is no longer filled can still be asked
GAP_S = 2.0


@dataclass(frozen=True, slots=True)
class Span:
    """Pictures of one source; ``has_before``: one of another place came before, of which there are some too."""

    pieces: list[Piece]
    has_before: bool = False


class Row:
    """Pictures in order of time, bounded in time and bytes."""

    def __init__(self, most_bytes: int) -> None:
        self._most_bytes, self._bytes = most_bytes, 0
        self._pieces: deque[tuple[str, Piece]] = deque()

    def add(self, piece: Piece, place: str = "") -> None:
        """Keep a picture, and where it is from; the oldest go."""
        self._pieces.append((place, piece))
        self._bytes += len(piece.data)
        oldest_ms = piece.captured_ms - KEPT_S * 1000
        while self._pieces and (self._bytes > self._most_bytes or self._pieces[0][1].captured_ms < oldest_ms):
            self._bytes -= len(self._pieces.popleft()[1].data)

    def between(self, from_ms: float, to_ms: float) -> Span:
        """Return what can be decoded of the last source of a span: from the last key picture before it on."""
        pieces = (one for one in self._pieces if one[1].captured_ms <= to_ms)
        runs = ([piece for _, piece in run] for _, run in itertools.groupby(pieces, lambda one: one[0]))
        found = [some for run in runs if (some := _decodable(run, from_ms))]
        return Span(found[-1], len(found) > 1) if found else Span([])

    def nearest(self, at_ms: float) -> Piece | None:
        """Return the picture nearest to a moment."""
        return min((one for _, one in self._pieces), key=lambda one: abs(one.captured_ms - at_ms), default=None)


def _decodable(pieces: list[Piece], from_ms: float) -> list[Piece]:
    """Return pictures from the last key picture before a moment on, none if all are older."""
    keys = [at for at, one in enumerate(pieces) if one.is_key]
    if not keys:
        return []
    before = [at for at in keys if pieces[at].captured_ms <= from_ms]
    found = pieces[before[-1] if before else keys[0] :]
    return found if found[-1].captured_ms >= from_ms else []


class _Tap:
    """Looks at a camera for a row; it is nobody who watches."""

    is_person = False

    def __init__(self, wish: Wish, row: Row, camera: Camera) -> None:
        self.wish, self._row, self._camera, self._last_ms = wish, row, camera, float("-inf")

    def take(self, piece: Piece) -> None:
        """See ``Watch``."""
        if self.wish.way is Way.JPEG and piece.captured_ms - self._last_ms < 900.0:
            return
        self._last_ms = piece.captured_ms
        self._row.add(piece, self._camera.source.place)


@dataclass(slots=True)
class Ring:
    """One camera's rows; ``ended_s`` is when it was no longer to be filled."""

    video: Row
    stills: Row
    taps: tuple[_Tap, _Tap]
    camera: Camera
    recording: Recording
    ended_s: float | None = None


class Rings:
    """All rings, as the console wants them."""

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self._wanted: dict[str, Recording] = {}
        self._rings: dict[str, Ring] = {}

    def __len__(self) -> int:
        return len(self._rings)

    def set(self, wanted: Sequence[Recording], cameras: dict[str, Camera]) -> None:
        """Take the whole list of what is kept."""
        self._wanted = {f"{one.robot}/{one.camera}": one for one in wanted}
        self.match(cameras)

    def match(self, cameras: dict[str, Camera]) -> None:
        """Begin rings whose camera is there now, and end those no longer wanted."""
        now_s = self._clock.mono_s()
        for name, ring in list(self._rings.items()):
            wanted = self._wanted.get(name)
            is_current = wanted == ring.recording and cameras.get(name) is ring.camera
            if ring.ended_s is None and not is_current:
                ring.ended_s, ring.camera.is_kept = now_s, False
                for tap in ring.taps:
                    ring.camera.leave(tap)
                asyncio.get_running_loop().call_later(AFTERWARDS_S, self._forget, name, ring)
        for name, wanted in self._wanted.items():
            camera = cameras.get(name)
            known = self._rings.get(name)
            if camera is not None and (known is None or known.ended_s is not None):
                self._rings[name] = _begun(camera, wanted, known)

    def _forget(self, name: str, ring: Ring) -> None:
        if self._rings.get(name) is ring:
            del self._rings[name]

    def of(self, robot: str, camera: str) -> Ring | None:
        """Return what is kept of a camera."""
        return self._rings.get(f"{robot}/{camera}")


def _begun(camera: Camera, wanted: Recording, before: Ring | None) -> Ring:
    video = Row(KEPT_BYTES) if before is None else before.video
    stills = Row(KEPT_BYTES // 2) if before is None else before.stills
    taps = (
        _Tap(Wish(Way.H264, wanted.width, wanted.fps), video, camera),
        _Tap(Wish(Way.JPEG, wanted.width, 1.0), stills, camera),
    )
    camera.is_kept = True
    for tap in taps:
        camera.join(tap)
    return Ring(video, stills, taps, camera, wanted)
