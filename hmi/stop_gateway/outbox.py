"""The presses that are not reset, on disk, so that a restarted gateway goes on with them.

Nothing waits for the disk: STOP is sent first, written after. A press made in the few milliseconds before a
crash is sent again by the browser that made it.
"""

from __future__ import annotations

import contextlib
import logging
import os
from datetime import datetime
from pathlib import Path

import msgspec
from msgspec import Struct

from hmi.clock import Clock
from hmi.domain.stop import StopAttempt, StopState, StopTarget

_log = logging.getLogger("headland.stop")


class Record(Struct, frozen=True):
    """One press at one robot; offsets are seconds after the press."""

    stop_id: str
    robot: str
    name: str
    by: str
    device: str
    pressed_utc: datetime
    state: StopState
    decel_mps2: float | None = None
    ack_limit_s: float = 1.0
    standstill_limit_s: float = 3.0
    press_speed_mps: float | None = None
    sent_after_s: float | None = None
    ack_after_s: float | None = None
    standstill_after_s: float | None = None
    count: int = 0
    mqtt_count: int = 0
    http_count: int = 0
    ack_boot: str = ""
    ack_at_s: float | None = None
    stopping_distance_m: float | None = None
    text: str = ""
    is_stranger: bool = False
    user_id: str | None = None

    @classmethod
    def of(cls, attempt: StopAttempt) -> Record:
        """Return the record of an attempt."""
        target = attempt.target
        return cls(
            stop_id=attempt.stop_id,
            robot=target.id,
            name=target.name,
            by=attempt.by,
            device=attempt.device,
            pressed_utc=attempt.pressed_utc,
            state=attempt.state,
            decel_mps2=target.decel_mps2,
            ack_limit_s=target.ack_limit_s,
            standstill_limit_s=target.standstill_limit_s,
            press_speed_mps=attempt.press_speed_mps,
            sent_after_s=_after(attempt, attempt.sent_s),
            ack_after_s=_after(attempt, attempt.ack_s),
            standstill_after_s=_after(attempt, attempt.standstill_s),
            count=attempt.count,
            mqtt_count=attempt.mqtt_count,
            http_count=attempt.http_count,
            ack_boot=attempt.ack_boot,
            ack_at_s=attempt.ack_at_s,
            stopping_distance_m=attempt.stopping_distance_m,
            text=attempt.text,
            is_stranger=target.is_stranger,
            user_id=attempt.user_id,
        )

    def attempt(self, clock: Clock) -> StopAttempt:
        """Return the attempt, due at once; its age comes from the wall clock, the only one that survives."""
        now_s = clock.mono_s()
        pressed_s = now_s - max(0.0, (clock.utc() - self.pressed_utc).total_seconds())
        target = StopTarget(
            self.robot, self.name, self.decel_mps2, self.ack_limit_s, self.standstill_limit_s, self.is_stranger
        )
        return StopAttempt(
            stop_id=self.stop_id,
            target=target,
            by=self.by,
            device=self.device,
            pressed_utc=self.pressed_utc,
            pressed_s=pressed_s,
            press_speed_mps=self.press_speed_mps,
            state=self.state,
            sent_s=_at(pressed_s, self.sent_after_s),
            ack_s=_at(pressed_s, self.ack_after_s),
            standstill_s=_at(pressed_s, self.standstill_after_s),
            count=self.count,
            mqtt_count=self.mqtt_count,
            http_count=self.http_count,
            repeat_from_s=now_s,
            next_send_s=now_s,
            ack_boot=self.ack_boot,
            ack_at_s=self.ack_at_s,
            stopping_distance_m=self.stopping_distance_m,
            text=self.text,
            user_id=self.user_id,
        )


_decoder = msgspec.json.Decoder(list[Record])


class OpenPress(Struct, frozen=True):
    """What the console reads of a press that the gateway holds; ``user_id`` as of ``StopAttempt``."""

    stop_id: str
    robot: str
    user_id: str | None = None


_open_presses = msgspec.json.Decoder(list[OpenPress])


def open_presses(path: Path) -> list[OpenPress]:
    """Return the presses that the outbox held when it was last written; none where it cannot be read. Blocks."""
    try:
        return _open_presses.decode(path.read_bytes())
    except FileNotFoundError:
        return []
    except (OSError, msgspec.DecodeError) as error:
        _log.error("the STOP outbox %s cannot be read: %s", path, error)
        return []


class Outbox:
    """The file; ``load`` and ``save`` block, so they run in a thread or before the loop starts."""

    def __init__(self, path: Path, clock: Clock) -> None:
        self._path = path
        self._clock = clock

    def load(self) -> list[StopAttempt]:
        """Return the presses of before the restart; a broken file is kept aside and said aloud."""
        try:
            records = _decoder.decode(self._path.read_bytes())
        except FileNotFoundError:
            return []
        except (OSError, msgspec.DecodeError) as error:
            _log.critical("the STOP outbox %s cannot be read, presses in it are lost: %s", self._path, error)
            with contextlib.suppress(OSError):
                self._path.replace(self._path.with_suffix(".broken"))
            return []
        return [record.attempt(self._clock) for record in records]

    def save(self, attempts: list[StopAttempt]) -> None:
        """Write all open presses; the file is the old or the new one, never half of it."""
        write_whole(self._path, msgspec.json.encode([Record.of(attempt) for attempt in attempts]))


def write_whole(path: Path, data: bytes) -> None:
    """Replace a file so that a reader, or a crash, sees the old or the new content; raises ``OSError``."""
    path.parent.mkdir(parents=True, exist_ok=True)
    draft = path.with_name(f".{path.name}.{os.getpid()}")
    with draft.open("wb") as file:
        file.write(data)
        file.flush()
        os.fsync(file.fileno())
    draft.replace(path)


def _after(attempt: StopAttempt, at_s: float | None) -> float | None:
    return None if at_s is None else round(at_s - attempt.pressed_s, 4)


def _at(pressed_s: float, after_s: float | None) -> float | None:
    return None if after_s is None else pressed_s + after_s
