"""One STOP press at one robot: what is known of it, never more.

::

    sent ──ack──> acknowledged ──standstill──> standstill ──reset──> reset
      │                │                         │   ^
      └── too late ────┴──> not-confirmed <──────┘   │   (moves after it confirmed)
                                 └────── late ───────┘

A press at an id that is no robot's ends as ``withdrawn``: that says nothing about any machine.

Pure: the caller gives the time. ``*_s`` without more are on the console's monotonic clock; the robot's own
time (``SafetyReport.at_s``) is only ever compared with itself.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from datetime import datetime
from enum import StrEnum
from typing import Any

ACK_LIMIT_S = 1.0  # safety rules: no acknowledgement within 1.0 s is not confirmed
STANDSTILL_LIMIT_S = 3.0  # safety rules: 3 s at most, however fast the machine was
SHORTEST_LIMIT_S = 0.2  # one repeat; below it every press would look failed
BRAKING_MARGIN_S = 1.0  # safety rules: v / deceleration + 1 s
REPEAT_S = 0.2  # 5 Hz until standstill is confirmed
SLOW_REPEAT_S = 1.0
SLOW_AFTER_S = 10.0  # after 10 s at 5 Hz the path is not just noisy
STANDING_MPS = 0.05  # noise of a standing machine's speed estimate
ALREADY_RESET = frozenset({"already_reset", "already-reset"})
"""Codes by which a robot says that this press was reset; valid whatever the outcome field says."""


STRANGER_HEARD_S = 60.0
"""A robot that nobody registered belongs to STOP ALL for so long after it was heard."""


class StopState(StrEnum):
    """What may be claimed about one press at one robot."""

    SENT = "sent"
    ACKNOWLEDGED = "acknowledged"
    STANDSTILL = "standstill"
    NOT_CONFIRMED = "not-confirmed"
    RESET = "reset"
    WITHDRAWN = "withdrawn"


def _limit(value: float | None, at_most: float) -> float:
    """Return a usable limit: a site may make it stricter, never longer and never off."""
    if value is None or not math.isfinite(value) or value <= 0:
        return at_most
    return min(max(value, SHORTEST_LIMIT_S), at_most)


@dataclass(frozen=True, slots=True)
class StopTarget:
    """A robot as STOP needs it; limits outside the rules are brought inside them.

    ``is_stranger``: when STOP was pressed nobody had registered it and nobody had heard it.
    """

    id: str
    name: str
    decel_mps2: float | None = None
    ack_limit_s: float = ACK_LIMIT_S
    standstill_limit_s: float = STANDSTILL_LIMIT_S
    is_stranger: bool = False

    @classmethod
    def unregistered(cls, robot_id: str) -> StopTarget:
        """Return a robot that is heard but not in the registry, with the limits of the rules; its name says so."""
        return cls(robot_id, f"{robot_id} (not registered)")

    def __post_init__(self) -> None:
        object.__setattr__(self, "ack_limit_s", _limit(self.ack_limit_s, ACK_LIMIT_S))
        object.__setattr__(self, "standstill_limit_s", _limit(self.standstill_limit_s, STANDSTILL_LIMIT_S))

    def braking_limit_s(self, speed_mps: float | None) -> float:
        """Return how long after the press standstill may take; an unknown speed gets the whole limit."""
        decel = self.decel_mps2
        if speed_mps is None or decel is None or not math.isfinite(speed_mps) or not decel > 0:
            return self.standstill_limit_s
        return min(abs(speed_mps) / decel + BRAKING_MARGIN_S, self.standstill_limit_s)


@dataclass(frozen=True, slots=True)
class SafetyReport:
    """What the robot's safety controller said at ``at_s`` of its own clock, which restarts with ``boot``.

    ``live`` and ``reset`` are the stop ids it holds latched, and those it lists as reset.
    """

    boot: str
    at_s: float
    latched: bool
    standstill: bool
    tool_off: bool
    hardware_stop: bool
    speed_mps: float
    live: frozenset[str] = frozenset()
    reset: frozenset[str] = frozenset()
    stopping_distance_m: float | None = None

    @property
    def is_standing(self) -> bool:
        """Whether nothing moves and the tool is off."""
        return self.standstill and self.tool_off and self.speed_mps <= STANDING_MPS


@dataclass(frozen=True, slots=True)
class StopAnswer:
    """The robot's acknowledgement of a press, by whatever path; ``at_s`` is ``None`` if it told no time."""

    is_accepted: bool
    code: str = "ok"
    text: str = ""
    speed_mps: float | None = None
    boot: str = ""
    at_s: float | None = None


@dataclass(frozen=True, slots=True)
class StopAttempt:
    """One press at one robot. Every method returns the attempt as it is afterwards.

    ``user_id`` is the account that pressed, from the signed stop token: empty where nobody was signed in, ``None``
    where it is not known. ``by`` is for people to read; names are not unique.
    ``press_speed_mps`` is how fast it may have been when the limits began to run, ``speed_mps`` the newest
    speed it told; ``None`` is unknown.
    """

    stop_id: str
    target: StopTarget
    by: str
    device: str
    pressed_utc: datetime
    pressed_s: float
    press_speed_mps: float | None = None
    speed_mps: float | None = None
    state: StopState = StopState.SENT
    sent_s: float | None = None
    ack_s: float | None = None
    standstill_s: float | None = None
    count: int = 0
    mqtt_count: int = 0
    http_count: int = 0
    repeat_from_s: float = 0.0
    next_send_s: float = 0.0
    unlatched_s: float | None = None
    ack_boot: str = ""
    ack_at_s: float | None = None
    stopping_distance_m: float | None = None
    text: str = ""
    user_id: str | None = None

    @classmethod
    def press(
        cls,
        stop_id: str,
        target: StopTarget,
        by: str,
        device: str,
        *,
        now_s: float,
        utc: datetime,
        speed_mps: float | None = None,
        user_id: str | None = None,
    ) -> StopAttempt:
        """Return a fresh attempt, due at once. ``speed_mps`` is the newest known speed, ``None`` if old."""
        return cls(
            stop_id,
            target,
            by,
            device,
            utc,
            now_s,
            press_speed_mps=speed_mps,
            speed_mps=speed_mps,
            repeat_from_s=now_s,
            next_send_s=now_s,
            user_id=user_id,
        )

    @property
    def robot_id(self) -> str:
        """The robot's id."""
        return self.target.id

    @property
    def is_open(self) -> bool:
        """Whether the press is still somebody's business: neither reset nor withdrawn."""
        return self.state not in (StopState.RESET, StopState.WITHDRAWN)

    @property
    def wants_sending(self) -> bool:
        """Whether copies still go out: until standstill is confirmed, and again if the latch seems gone."""
        return self.is_open and (self.state is not StopState.STANDSTILL or self.unlatched_s is not None)

    @property
    def ack_deadline_s(self) -> float:
        """When a missing acknowledgement becomes NOT CONFIRMED."""
        return self.pressed_s + self.target.ack_limit_s

    @property
    def standstill_deadline_s(self) -> float:
        """When a missing standstill becomes NOT CONFIRMED."""
        return self.pressed_s + self.target.braking_limit_s(self.press_speed_mps)

    @property
    def next_change_s(self) -> float | None:
        """When time alone changes the state, ``None`` if it does not."""
        match self.state:
            case StopState.SENT:
                return min(self.ack_deadline_s, self.standstill_deadline_s)
            case StopState.ACKNOWLEDGED:
                return self.standstill_deadline_s
            case StopState.STANDSTILL if self.unlatched_s is not None:
                return self.unlatched_s + self.target.ack_limit_s
        return None

    def at(self, now_s: float) -> StopAttempt:
        """Return the attempt after time passed."""
        change_s = self.next_change_s
        if change_s is None or now_s < change_s:
            return self
        if self.state is StopState.STANDSTILL:
            return self._contradicted(now_s, "The robot says it is no longer latched.")
        if self.ack_s is None and now_s >= self.ack_deadline_s:
            text = f"No acknowledgement within {self.target.ack_limit_s:.1f} s."
        else:
            text = f"No standstill within {self.standstill_deadline_s - self.pressed_s:.1f} s."
        return replace(self, state=StopState.NOT_CONFIRMED, text=self.text or text)

    def pressed_again(self, now_s: float) -> StopAttempt:
        """Send once more now; a press is never swallowed, in whatever state."""
        if not self.is_open:
            return self
        return replace(self, next_send_s=now_s, repeat_from_s=now_s)

    def returned(self, now_s: float) -> StopAttempt:
        """The robot, or the path to it, is back: what is not confirmed goes first, at once."""
        return self.pressed_again(now_s) if self.wants_sending else self

    def is_due(self, now_s: float) -> bool:
        """Say whether a copy must go out now."""
        return self.is_open and now_s >= self.next_send_s

    def sent(self, now_s: float, *, by_mqtt: bool) -> StopAttempt:
        """A round of copies went out at ``now_s``; HTTP counts when it was answered, see ``carried_by_http``."""
        interval_s = SLOW_REPEAT_S if now_s - self.repeat_from_s >= SLOW_AFTER_S else REPEAT_S
        return replace(
            self,
            count=self.count + 1,
            mqtt_count=self.mqtt_count + by_mqtt,
            sent_s=now_s if by_mqtt and self.sent_s is None else self.sent_s,
            next_send_s=now_s + interval_s if self.wants_sending else math.inf,
        )

    def carried_by_http(self, sent_s: float) -> StopAttempt:
        """The robot's HTTP endpoint took the copy that left at ``sent_s``."""
        first_s = sent_s if self.sent_s is None else min(self.sent_s, sent_s)
        return replace(self, http_count=self.http_count + 1, sent_s=first_s)

    def answered(self, now_s: float, answer: StopAnswer) -> StopAttempt:
        """The robot answered this press."""
        now = self.at(now_s)
        if not now.is_open:
            return now
        if answer.code in ALREADY_RESET:
            return replace(now, state=StopState.RESET, text="")
        if not answer.is_accepted:  # a refused stop is no acknowledgement: the limits run on, copies go on
            return replace(now, text=answer.text or f"The robot refused: {answer.code}.")
        acked = now if now.ack_s is not None else replace(now, ack_s=now_s, text=now._without_refusal())
        if answer.at_s is not None and (acked.ack_at_s is None or acked.ack_boot != answer.boot):
            acked = replace(acked, ack_boot=answer.boot, ack_at_s=answer.at_s)
        if answer.speed_mps is not None:
            # it may have been faster than last heard: more time to brake, still under the limit
            press_mps = _faster(acked.press_speed_mps, answer.speed_mps)
            acked = replace(acked, speed_mps=answer.speed_mps, press_speed_mps=press_mps)
        state = StopState.ACKNOWLEDGED if acked.state is StopState.SENT else acked.state
        return replace(acked, state=state)

    def reported(self, now_s: float, report: SafetyReport) -> StopAttempt:
        """The robot's safety controller reported; reports must come in the order the robot made them."""
        now = self.at(now_s)
        if not now.is_open:
            return now
        if now.stop_id in report.reset and now.stop_id not in report.live:
            return replace(now, state=StopState.RESET, text="")
        if now.state is StopState.STANDSTILL:
            return now._checked(now_s, report)
        if not now._is_about_this_press(report):
            return now
        if now.ack_s is None:  # holding the press is as good as the acknowledgement that got lost
            now = now.answered(now_s, StopAnswer(True, boot=report.boot, at_s=report.at_s))
        if report.latched and report.is_standing:
            return replace(
                now,
                state=StopState.STANDSTILL,
                standstill_s=now_s,
                speed_mps=report.speed_mps,
                unlatched_s=None,
                next_send_s=math.inf,
                stopping_distance_m=report.stopping_distance_m,
                text="Hardware button is pressed on the machine." if report.hardware_stop else "",
            )
        return replace(now, speed_mps=report.speed_mps)

    def step(self, now_s: float) -> dict[str, Any]:
        """Return the ``step`` frame of the STOP protocol; ``*_ms`` count from the press."""
        return {
            "k": "step",
            "stop_id": self.stop_id,
            "robot": self.target.id,
            "name": self.target.name,
            "state": self.state.value,
            "by": self.by,
            "device": self.device,
            "pressed_utc": self.pressed_utc.isoformat(timespec="milliseconds").replace("+00:00", "Z"),
            "age_ms": self._ms(now_s),
            "sent_ms": self._ms(self.sent_s),
            "ack_ms": self._ms(self.ack_s),
            "standstill_ms": self._ms(self.standstill_s),
            "count": self.count,
            "paths": {"mqtt": self.mqtt_count, "http": self.http_count},
            "speed_mps": self.speed_mps,
            "stopping_distance_m": self.stopping_distance_m,
            "text": self.text,
        }

    def _ms(self, at_s: float | None) -> int | None:
        return None if at_s is None else max(0, round((at_s - self.pressed_s) * 1000))

    def _without_refusal(self) -> str:
        return self.text if self.state is StopState.NOT_CONFIRMED else ""

    def _is_about_this_press(self, report: SafetyReport) -> bool:
        """Say whether the robot had this press when it reported: an older standstill proves nothing."""
        if self.stop_id in report.live:
            return True
        return self.ack_at_s is not None and report.boot == self.ack_boot and report.at_s >= self.ack_at_s

    def _checked(self, now_s: float, report: SafetyReport) -> StopAttempt:
        if not report.is_standing:
            moving = replace(self, speed_mps=report.speed_mps)
            return moving._contradicted(now_s, "It moves although it confirmed standstill.")
        if report.latched:
            return self if self.unlatched_s is None else replace(self, unlatched_s=None, next_send_s=math.inf)
        if self.unlatched_s is None:  # reset, or latch lost: the answer to one more copy tells which
            return replace(self, unlatched_s=now_s, next_send_s=now_s, repeat_from_s=now_s)
        return self

    def _contradicted(self, now_s: float, text: str) -> StopAttempt:
        return replace(
            self,
            state=StopState.NOT_CONFIRMED,
            standstill_s=None,
            unlatched_s=None,
            repeat_from_s=now_s,
            next_send_s=now_s,
            text=text,
        )


def _faster(known_mps: float | None, told_mps: float) -> float | None:
    return None if known_mps is None else max(known_mps, told_mps)
