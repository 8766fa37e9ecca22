"""Tells the stations of a parcel that treatment is under way there, for as long as it is.

A notice ends by itself: a station obeys it until its time and no longer, so a console that is killed leaves nothing
behind that goes on. It is renewed while the treatment goes on and withdrawn at its end. What a station has not
acknowledged is never shown as acknowledged.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import datetime, timedelta
from enum import StrEnum

from hmi.clock import Clock
from hmi.domain.ids import new_id
from hmi.domain.sensors.order import NoticeOrder, StationSender
from hmi.domain.sensors.station import FieldStation, StationAnswer

HOLDS_S = 600.0  # how long a notice is obeyed; no more than this is left behind by a console that dies
RENEW_S = 240.0
ANSWER_S = 15.0
RETRY_S = 60.0
MOST_ROBOTS = 64
NO_LINK = "No link to the broker: not sent."


class NoticeState(StrEnum):
    """What is known of a notice."""

    SENT = "sent"
    ACKNOWLEDGED = "acknowledged"
    REFUSED = "refused"
    UNCONFIRMED = "unconfirmed"


@dataclass(frozen=True, slots=True)
class Treatment:
    """Robots that treat a parcel now, by id, and what people call them."""

    parcel: str
    parcel_name: str
    robots: tuple[str, ...]
    names: tuple[str, ...] = field(default=(), compare=False)  # another name is nothing that a station has to be told


@dataclass(slots=True)
class Notice:
    """What a station was told last.

    Args:
        since: when the treatment it is about began here.
        sent_s: monotonic; below every time if it could not be sent.
        is_answered: whether the newest one was; a renewal that is not leaves nothing acknowledged.
    """

    treatment: Treatment
    since: datetime
    ref: str = ""
    sent_s: float = float("-inf")
    state: NoticeState = NoticeState.UNCONFIRMED
    answer: str = ""
    is_answered: bool = False
    is_ending: bool = False
    ended_s: float = 0.0

    @property
    def text(self) -> str:
        """What it is about, in words."""
        one = self.treatment
        where = f"Treatment on {one.parcel_name}, {', '.join(one.names or one.robots)}"
        over = ", over" if self.is_ending else ""
        return f"{where}{over}. {self.answer}".strip() if self.answer else f"{where}{over}"


class TreatmentNotices:
    """Keeps the notices of every station; belongs to the event loop.

    Args:
        stations: the accepted stations.
        on_changed: told of a station whose notice changed.
    """

    def __init__(
        self,
        sender: StationSender,
        clock: Clock,
        stations: Callable[[], Sequence[FieldStation]],
        on_changed: Callable[[str], None] = lambda _station: None,
    ) -> None:
        self._sender, self._clock, self._stations, self._on_changed = sender, clock, stations, on_changed
        self._notices: dict[str, Notice] = {}
        self._is_tidy = False

    def of(self, station_id: str) -> Notice | None:
        """Return what a station was told, ``None`` for nothing."""
        return self._notices.get(station_id)

    def round(self, treatments: Mapping[str, Treatment]) -> None:
        """Bring every station up to date; ``treatments`` by parcel. Call it every few seconds."""
        stations = {one.id: one for one in self._stations()}
        self._tidy(stations, treatments)
        for station_id in [one for one in self._notices if one not in stations]:
            self._drop(station_id)
        for station in stations.values():
            wanted = treatments.get(station.parcel) if station.parcel else None
            if wanted is not None:
                self._keep(station.id, wanted)
            elif station.id in self._notices:
                self._end(station.id, self._notices[station.id])

    def answered(self, answer: StationAnswer) -> None:
        """Take an answer; one to an older notice says nothing about this one."""
        notice = self._notices.get(answer.station_id)
        if notice is None or notice.ref != answer.ref:
            return
        notice.is_answered = True
        notice.answer = "" if answer.is_accepted else answer.text
        self._set(answer.station_id, notice, NoticeState.ACKNOWLEDGED if answer.is_accepted else NoticeState.REFUSED)

    def _tidy(self, stations: Mapping[str, FieldStation], treatments: Mapping[str, Treatment]) -> None:
        """Take away, once, what a console before us may have left at the broker."""
        if self._is_tidy or not self._sender.is_up or not stations:
            return
        self._is_tidy = True
        for station in stations.values():
            if station.parcel not in treatments and station.id not in self._notices:
                self._sender.clear_notice(station.id)

    def _keep(self, station_id: str, wanted: Treatment) -> None:
        notice = self._notices.get(station_id)
        if notice is None or notice.is_ending:
            notice = self._notices[station_id] = Notice(wanted, self._clock.utc())
        elif notice.treatment != wanted:
            notice.treatment, notice.sent_s = wanted, float("-inf")
        if self._is_due(notice):
            self._send(station_id, notice, is_treating=True)
        self._wait(station_id, notice)

    def _end(self, station_id: str, notice: Notice) -> None:
        now_s = self._clock.mono_s()
        if not notice.is_ending:
            notice.is_ending, notice.ended_s, notice.sent_s = True, now_s, float("-inf")
            notice.answer = ""
        is_known = notice.state is NoticeState.ACKNOWLEDGED and notice.is_answered and notice.sent_s >= notice.ended_s
        if is_known or now_s - notice.ended_s > HOLDS_S:  # by now it has ended by itself, whatever was heard
            self._drop(station_id)
            return
        if self._is_due(notice):
            self._send(station_id, notice, is_treating=False)
        self._wait(station_id, notice)

    def _is_due(self, notice: Notice) -> bool:
        waited_s = self._clock.mono_s() - notice.sent_s
        is_settled = notice.state in (NoticeState.ACKNOWLEDGED, NoticeState.SENT) and not notice.is_ending
        return waited_s >= (RENEW_S if is_settled else RETRY_S)

    def _send(self, station_id: str, notice: Notice, *, is_treating: bool) -> None:
        now, is_renewal = self._clock.utc(), notice.sent_s > float("-inf") and is_treating
        notice.ref, notice.is_answered = new_id(), False
        order = NoticeOrder(
            station_id, notice.ref, now, is_treating,
            notice.treatment.robots[:MOST_ROBOTS] if is_treating else (),
            notice.treatment.parcel if is_treating else "", now + timedelta(seconds=HOLDS_S),
        )  # fmt: skip
        if not self._sender.send(order):
            notice.answer, notice.sent_s = NO_LINK, float("-inf")
            self._set(station_id, notice, NoticeState.UNCONFIRMED)
            return
        notice.sent_s = self._clock.mono_s()
        if not (is_renewal and notice.state is NoticeState.ACKNOWLEDGED):  # what was acknowledged still holds
            notice.answer = ""
            self._set(station_id, notice, NoticeState.SENT)

    def _wait(self, station_id: str, notice: Notice) -> None:
        """What was not answered in time is not confirmed."""
        is_sent = notice.sent_s > float("-inf") and not notice.is_answered
        if is_sent and self._clock.mono_s() - notice.sent_s > ANSWER_S:
            notice.answer = "Not acknowledged."
            self._set(station_id, notice, NoticeState.UNCONFIRMED)

    def _drop(self, station_id: str) -> None:
        self._sender.clear_notice(station_id)
        del self._notices[station_id]
        self._on_changed(station_id)

    def _set(self, station_id: str, notice: Notice, state: NoticeState) -> None:
        if notice.state is not state:
            notice.state = state
            self._on_changed(station_id)
