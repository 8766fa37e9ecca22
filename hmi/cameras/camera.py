"""One camera: who looks at it, its worker while somebody does, and how it is."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Callable
from dataclasses import replace
from typing import Any, Protocol

from hmi.cameras.demand import Way, Wish, plan_of, step_of
from hmi.cameras.group import Group
from hmi.cameras.picture_wire import KeyPicture, Kind, News, Order, Piece, Plan
from hmi.cameras.worker_process import WorkerProcess
from hmi.clock import Clock
from hmi.domain.camera import CameraState, Source, SourceKind, frozen_after_s

log = logging.getLogger(__name__)
BACKOFF_S = (0.5, 1.0, 2.0, 5.0, 10.0)
STEADY_S = 10.0  # pictures for so long: the next failure begins with the shortest wait
LINGER_S = 5.0  # a page that is loaded again finds the camera running
TICK_S = 0.2
SILENT_S = 5.0  # without a new picture for so long its source is opened anew
PERIODS = 4  # for slower ones
STARTS_S = 30.0  # so long a worker may take to say its first word; until then its camera is not called silent
MOST_SILENT_S = 60.0  # opening it anew did not help: twice as long each time, for its scene may really stand still
MOST_IN_GROUP = 300
NEWEST_S = 1.0  # an older still gives way to a smaller one
WAYS = {Kind.H264: Way.H264, Kind.VP8: Way.VP8, Kind.JPEG: Way.JPEG}


class Watch(Protocol):
    """Somebody who looks."""

    @property
    def wish(self) -> Wish:
        """What is wanted; asked again at each ``Camera.replan``."""
        ...

    @property
    def is_person(self) -> bool:
        """Whether somebody looks, and not a recorder."""
        ...

    def take(self, piece: Piece) -> None:
        """Take one picture; must not block."""
        ...


class Hearer(Protocol):
    """Somebody who is told of changes."""

    def tell(self, camera: Camera) -> None:
        """Its state changed."""
        ...


class Camera:
    """All on one event loop.

    Args:
        video_width: wider pictures are made smaller before they are encoded for WebRTC.
        refusal: says why no further worker may be started, empty if one may.
    """

    def __init__(self, source: Source, clock: Clock, video_width: int, refusal: Callable[[], str] = lambda: "") -> None:
        self.source, self._clock, self._video_width = source, clock, video_width
        self._refusal = refusal
        self.watches: set[Watch] = set()
        self._ways: dict[Watch, Way] = {}  # asked once: pictures are many
        self.hearers: set[Hearer] = set()
        self.is_kept = False  # its last minute is
        self.newest: Piece | None = None
        self.newest_jpeg: Piece | None = None
        self._group: Group[Piece] = Group(MOST_IN_GROUP)
        self.restarts, self.reason, self.fps, self.kbit_s = 0, "", 0.0, 0.0
        self._worker: WorkerProcess | None = None
        self._task: asyncio.Task[None] | None = None
        self._again, self._is_let_go = asyncio.Event(), False
        self._plan = Plan()
        self._arrived_s: float | None = None
        self._began_s = self._looked_s = 0.0
        self._is_renewed = False  # the worker ends because it shall
        self._has_spoken = True
        self._silences = 0  # workers in a row that were ended because nothing new came
        self._ending = ""
        self._news: tuple[float, News] | None = None
        self._told: tuple[Any, ...] = ()
        self._seq = self._seq_before = 0  # of earlier workers, each of which begins at 1
        self._mark = ""

    @property
    def worker_pid(self) -> int | None:
        """Process id of its worker while it has one."""
        return None if self._worker is None else self._worker.pid

    @property
    def group(self) -> list[Piece]:
        """H.264 since the last key picture."""
        return self._group.row

    @property
    def state(self) -> CameraState:
        """How it does."""
        is_upload = self.source.kind is SourceKind.UPLOAD
        if self._is_fresh() and (is_upload or self._task is not None):
            return CameraState.LIVE
        if not self.source.is_on:
            return CameraState.OFF
        if is_upload:
            return CameraState.IDLE if self.newest is None else CameraState.FROZEN
        if self._task is None:
            return CameraState.IDLE
        if self._worker is None or self._arrived_s is None:
            return CameraState.FAILED if self.reason else CameraState.STARTING
        return CameraState.FROZEN

    @property
    def pulled_width(self) -> int | None:
        """How wide pictures are asked for now (0: any), ``None`` while it is not pulled."""
        return None if self._task is None else self._plan.width

    def join(self, watch: Watch) -> None:
        """Somebody looks."""
        self.watches.add(watch)
        self._ways[watch] = watch.wish.way
        self.replan()
        self._begin()
        self._tell()

    def leave(self, watch: Watch) -> None:
        """Somebody looks away."""
        self.watches.discard(watch)
        self._ways.pop(watch, None)
        self.replan()
        self._tell()

    def replan(self) -> None:
        """What is wanted changed; while nobody looks the plan stays, for the little while it lingers."""
        self._looked_s = self._clock.mono_s()
        if not self.watches:
            return
        plan = plan_of((watch.wish for watch in self.watches), self.source.camera, self._video_width)
        if plan != self._plan:
            self._plan = plan
            self._order(plan)

    def ask_key(self) -> None:
        """Somebody needs a picture that can be decoded alone."""
        self._order(KeyPicture())

    def change(self, source: Source) -> None:
        """Its source is another now; a robot that came or went opens nothing anew."""
        before, self.source = self.source, source
        if replace(source, is_on=before.is_on) != before:
            if replace(source, is_on=before.is_on, camera=before.camera, period_s=before.period_s) != before:
                self._forget()
            if self.watches:
                self.replan()
            else:
                self._looked_s = float("-inf")  # nobody looks: it does not linger at another source
            self.restart()
            if self.watches:
                self._begin()
        self._tell()

    def restart(self) -> None:
        """Open the source anew, now."""
        self._is_renewed, self._silences, self.reason = True, 0, ""
        if self._worker is not None:
            self._worker.kill()
        self._again.set()

    async def end(self) -> None:
        """Let go of everything."""
        self.watches.clear()
        self._ways.clear()
        task, self._task = self._task, None
        if task is not None:
            task.cancel()
            await asyncio.gather(task, return_exceptions=True)

    def upload(self, data: bytes, width: int, height: int, captured_ms: float) -> None:
        """Take a picture that its camera sent by itself; one taken before the newest is not shown any more."""
        if self.newest is not None and captured_ms < self.newest.captured_ms:
            return
        self._take(Piece(Kind.JPEG, data, captured_ms, self._seq + 1, width, height))
        self._arrived_s = captured_ms / 1000  # one that waited at its camera is not fresh because it came now
        self._tell()

    def describe(self) -> dict[str, Any]:
        """Return it as ``Camera`` of the protocol."""
        info = self.source.camera
        return {
            "robot": self.source.robot,
            "camera": info.id,
            "label": info.label,
            "kind": info.kind,
            "view": info.view,
            "width_px": info.width_px,
            "height_px": info.height_px,
            "fov_deg": info.fov_deg,
            "ptz": info.ptz,
            "has_lamp": info.has_lamp,
            "has_trigger": info.has_trigger,
            "state": self.state.value,
            "reason": self.reason,
            "restarts": self.restarts,
            "viewers": sum(watch.is_person for watch in self.watches),
            "is_kept": self.is_kept and self.state is CameraState.LIVE,
            "fps": round(self.fps, 1),
            "period_s": round(self.source.expected_period_s, 3),
            "kbit_s": round(self.kbit_s),
            "captured": None if self.newest is None else round(self.newest.captured_ms, 1),
            "is_dated": self.newest is not None and self.newest.is_dated,
            "source": self.source.kind.value,
        }

    def _begin(self) -> None:
        """Pull it, if that is not done already and it is a camera that is pulled."""
        if self._task is None and self.source.kind is not SourceKind.UPLOAD:
            self.reason, self._arrived_s = "", None
            self._task = asyncio.get_running_loop().create_task(self._serve(), name=f"camera {self.source.name}")

    def _forget(self) -> None:
        """Its pictures come from elsewhere now: what the old place sent says nothing of the new one."""
        self.newest = self.newest_jpeg = self._arrived_s = self._news = None
        self.restarts, self.reason, self._mark = 0, "", ""
        self._group.clear()

    async def _serve(self) -> None:
        """Keep a worker for as long as somebody looks, and a little longer."""
        failures, self._silences, self._mark = 0, 0, ""
        ticker = asyncio.create_task(self._tick(), name=f"tick {self.source.name}")
        try:
            while True:
                began_s = self._clock.mono_s()
                reason = await self._one_worker()
                if not self._is_wanted():
                    return
                if self._is_let_go or self._is_renewed:
                    continue  # somebody looked again while it ended, or wanted that it ends; nothing failed
                failures = 0 if self._clock.mono_s() - began_s > STEADY_S and self._arrived_s else failures
                self.restarts += 1
                self.reason = reason or self.reason or "it ended"
                log.info("camera %s: %s", self.source.name, self.reason)
                self._tell()
                wait_s = BACKOFF_S[min(failures, len(BACKOFF_S) - 1)]
                failures = 0 if await self._paused(wait_s) else failures + 1
                if not self._is_wanted():
                    return
        finally:
            ticker.cancel()
            self._task = None
            self.fps = self.kbit_s = 0.0
            self._tell()

    async def _one_worker(self) -> str:
        """Start a worker and take what it makes until it ends; return why it did."""
        self._again.clear()
        self._is_let_go = self._is_renewed = False
        self._arrived_s, self._news, self._ending = None, None, ""
        self._group.clear()
        self._seq_before = self._seq
        if no := self._refusal():
            return no
        try:
            worker = self._worker = await WorkerProcess.start(self.source, self._plan, self._mark)
        except OSError as error:
            return f"no worker could be started ({error.strerror})"
        self._began_s, self._has_spoken = self._clock.mono_s(), False
        self._order(self._plan)  # it may have changed while the worker started
        ended = crash = ""
        try:
            async for message in worker.messages():
                if self._is_renewed:
                    break  # what it still says is of a source that may be another one
                ended = self._heard(message) or ended
        except Exception:
            log.exception("camera %s: a picture could not be handed on", self.source.name)
        finally:
            self._worker = None
            crash = await asyncio.shield(worker.end())
        return ended or self._ending or crash

    def _heard(self, message: Piece | News) -> str:
        """Take what a worker says; return why it ends, if it says that."""
        if not self._has_spoken:
            self._began_s, self._has_spoken = self._clock.mono_s(), True
        if isinstance(message, News):
            self._count(message)
            return message.ended
        self._take(replace(message, seq=self._seq_before + message.seq))
        return ""

    async def _paused(self, wait_s: float) -> bool:
        """Wait before the next try; return whether somebody asked for it."""
        try:
            async with asyncio.timeout(wait_s):
                await self._again.wait()
        except TimeoutError:
            return False
        return True

    async def _tick(self) -> None:
        while True:
            await asyncio.sleep(TICK_S)
            if not self._is_wanted() and self._worker is not None:
                self._is_let_go = True
                self._worker.let_go()  # its messages end, and with them the task
            elif self._worker is not None and not self._ending:
                self._end_silent(self._worker)
            self._tell()

    def _end_silent(self, worker: WorkerProcess) -> None:
        """End a worker that has had nothing new for long, whatever its camera goes on sending."""
        least_s = max(SILENT_S, PERIODS * self._period_s)
        patience_s = max(least_s, min(MOST_SILENT_S, least_s * 2**self._silences))
        if self._news is not None and self._news[1].waits_key:
            patience_s = max(patience_s, MOST_SILENT_S)  # opened anew it would wait anew
        now_s = self._clock.mono_s()
        if now_s - (self._arrived_s or self._began_s) <= (patience_s if self._has_spoken else STARTS_S):
            return
        if not self._has_spoken:
            self._ending = "it could not be opened in time: this machine is too busy"
            worker.let_go()
            return
        self._silences = 1 if now_s - self._began_s > 2 * MOST_SILENT_S else self._silences + 1
        why = "" if self._news is None or not self._news[1].bad else f": {self._news[1].why}"
        self._ending = f"the camera sends nothing new{why}"
        worker.let_go()

    def _is_wanted(self) -> bool:
        if self.source.kind is SourceKind.UPLOAD:
            return False
        return bool(self.watches) or self._clock.mono_s() - self._looked_s < LINGER_S

    def _take(self, piece: Piece) -> None:
        is_again = self.newest is not None and piece.captured_ms == self.newest.captured_ms
        self.newest, self._seq = piece, piece.seq
        if not is_again:  # a picture in another form, or the last one of a silent camera for who comes late
            self._arrived_s, self.reason = self._clock.mono_s(), ""
        if piece.kind is Kind.JPEG:
            if piece.wanted_width == 0 or self._is_better(piece, self.newest_jpeg):
                self.newest_jpeg = piece
        elif piece.kind is Kind.H264:
            self._group.add(piece)
        for watch in tuple(self.watches):
            if self._ways.get(watch) is WAYS[piece.kind] and self._is_for(piece, watch):
                watch.take(piece)
        self._tell()

    @staticmethod
    def _is_better(piece: Piece, before: Piece | None) -> bool:
        """Whether a still takes the place of the one before: the larger one, unless nobody wants that any more."""
        if before is None or piece.width >= before.width:
            return True
        return piece.captured_ms - before.captured_ms > NEWEST_S * 1000

    def _is_for(self, piece: Piece, watch: Watch) -> bool:
        if piece.kind is not Kind.JPEG or self.source.kind is SourceKind.UPLOAD:
            return True
        return step_of(watch.wish.width, self.source.camera) == piece.wanted_width

    def _count(self, news: News) -> None:
        now_s = self._clock.mono_s()
        if self._news is not None and now_s - self._news[0] > 0.2:
            span_s = now_s - self._news[0]
            self.fps = (news.pictures - self._news[1].pictures) / span_s
            self.kbit_s = (news.size - self._news[1].size) * 8 / 1000 / span_s
        bad = news.bad - (0 if self._news is None else self._news[1].bad)
        self._news, self._mark = (now_s, news), news.mark
        if bad and not self._is_fresh():
            self.reason = f"{news.bad} pictures could not be used: {news.why}"
        elif news.waits_key and self._arrived_s is None:
            self.reason = "waiting for the camera's next key picture"
        self._tell()

    @property
    def _period_s(self) -> float:
        """Seconds between two pictures as they are asked for now."""
        return max(self.source.expected_period_s, 1.0 / self._plan.fps)

    def _is_fresh(self) -> bool:
        if self._arrived_s is None:
            return False
        return self._clock.mono_s() - self._arrived_s <= frozen_after_s(self._period_s)

    def _order(self, order: Order) -> None:
        if self._worker is not None:
            self._worker.order(order)

    def _tell(self) -> None:
        """Tell those who listen if what they show changed."""
        shown = (self.state, self.reason, self.restarts, self.source)
        before = self._told[:-1]
        fps = self._told[-1] if self._told else 0.0
        if shown == before and abs(self.fps - fps) <= 0.1 * max(fps, 0.1):
            return
        self._told = (*shown, self.fps)
        for hearer in tuple(self.hearers):
            hearer.tell(self)
