"""What is known at the moment a queue decides. ``None`` means not known, and what is not known never counts as good."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime
from zoneinfo import ZoneInfo

from hmi.domain.forecast import Forecast
from hmi.domain.mission import MissionStatus
from hmi.domain.queue.blackout import Blackout
from hmi.domain.robot import Mode, OrderStatus
from hmi.domain.sensors.gate import Gate

FRESH_S = 2.0  # link, safety and state, which comes twice a second: as for a person's command
VALUE_FRESH_S = 10.0  # battery and position fix, which come ten times a second
WEATHER_FRESH_S = 900.0  # stations report each one to ten minutes


@dataclass(frozen=True, slots=True)
class Weather:
    """What a station said, and when; one value may be missing."""

    at: datetime
    rain_mm_h: float | None = None
    wind_mps: float | None = None
    station: str = ""


@dataclass(frozen=True, slots=True)
class RobotFacts:
    """One robot now; ages in seconds, ``None`` never heard.

    Args:
        stop: why it may not move at all (STOP latched, button pressed), empty if it may.
        safety_age_s: age of what its safety controller said.
        held: name of the mission it holds or drives, with its id and hash.
        trouble: a fault of high level, in its words.
        hold: why it does not go on by itself, in its words.
        state_age_s: age of mode, order, trouble and hold.
        value_age_s: age of battery and fix.
        cannot: which function that its work needs is off, and what turns it on; empty if none is.
    """

    name: str
    is_unattended_allowed: bool = False
    link_age_s: float | None = None
    safety_age_s: float | None = None
    stop: str = ""
    mode: Mode = Mode.UNKNOWN
    order: OrderStatus = OrderStatus.NONE
    held_id: str = ""
    held_sha256: str = ""
    held_name: str = ""
    trouble: str = ""
    hold: str = ""
    state_age_s: float | None = None
    value_age_s: float | None = None
    soc: float | None = None
    fix: str | None = None
    cannot: str = ""


@dataclass(frozen=True, slots=True)
class MissionFacts:
    """The mission of an entry. ``battery_share`` is what it needs of a full battery."""

    name: str
    status: MissionStatus
    sha256: str
    is_supervised: bool
    battery_share: float | None = None


@dataclass(frozen=True, slots=True)
class Facts:
    """Everything one decision is made of.

    Args:
        ahead: name of the mission before it in the queue, empty if it is its turn.
        is_ahead_running: that one is driven now.
        may_replace: the queue itself sent what the robot holds, or a person said that it may be replaced.
        frozen: why the whole queue stands still, empty if it does not.
        armed_until: until when this queue is armed, ``None`` if it is not.
        disarmed: why it is not armed any more, empty if it never was.
        owner: who has control instead of the queue, empty if nobody.
        treatment: what field stations say of the farm's treatment limits, ``None`` if nobody is asked.
        weather: what is measured: rules go by it alone.
        forecast: says when a rule that waits is expected to clear, and decides nothing.
        pause: what the queue itself waits for after a refusal, with until when.
    """

    now: datetime
    zone: ZoneInfo
    robot: RobotFacts | None
    mission: MissionFacts | None
    ahead: str = ""
    is_ahead_running: bool = False
    may_replace: bool = False
    frozen: str = ""
    armed_until: datetime | None = None
    disarmed: str = ""
    owner: str = ""
    blackouts: Sequence[Blackout] = ()
    weather: Weather | None = None
    treatment: Gate | None = None
    forecast: Forecast | None = None
    pause: tuple[str, datetime] | None = None
