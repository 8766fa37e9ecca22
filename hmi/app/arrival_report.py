"""What was lost or came twice on the way from robots to this console, for people and for Prometheus."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from datetime import timedelta
from typing import Any

from hmi.api.metrics import Gauge
from hmi.clock import Clock
from hmi.ingest.arrivals import Arrivals, Count
from hmi.store.fleet import FleetStore

MOST_SHOWN = 20  # robots in the list, those that lost most first
MOST_SERIES = 500  # series of single robots that one scrape gets, those that lost most first
_WHAT = ("received", "lost", "late", "twice", "out_of_order")


@dataclass(frozen=True, slots=True)
class FromRobots:
    """How the way from the robots is.

    Args:
        refused: what arrived and did not count, reason -> how often; see ``hmi.ingest.tally``.
        arrivals: see ``ArrivalReport.whole``.
    """

    refused: Callable[[], Mapping[str, int]] = dict
    arrivals: Callable[[], dict[str, Any]] = dict


class ArrivalReport:
    """Reads the counts when somebody looks."""

    def __init__(self, arrivals: Arrivals, fleet: FleetStore, clock: Clock) -> None:
        self._arrivals, self._fleet, self._clock = arrivals, fleet, clock

    def whole(self) -> dict[str, Any]:
        """Return totals since the start, each kind of message, and the robots that lost something or said it twice."""
        total, by_robot = Count(), self._arrivals.by_robot()
        for count in self._arrivals.by_kind().values():
            total.add(count)
        heard = [one for one in self._fleet.registered_ids() if self._fleet.was_heard(one)]
        robots = [self._robot(robot, kinds) for robot, kinds in by_robot.items()]
        worst = sorted(
            (one for one in robots if one["kinds"]), key=lambda one: (-one["lost"], -one["twice"], one["id"])
        )
        return {
            **self._told(total),
            "kinds": {kind.value: self._told(count) for kind, count in sorted(self._arrivals.by_kind().items())},
            "robots": worst[:MOST_SHOWN],
            "more_robots": max(0, len(worst) - MOST_SHOWN),
            "numbered": len(by_robot),
            "not_numbered": sum(one not in by_robot for one in heard),
        }

    def gauges(self) -> list[Gauge]:
        """Return the figures for Prometheus: totals of every kind, and what single robots lost."""
        return [
            *(Gauge(f"robot_messages_{one}", text, self._of_kinds(one), "kind", True) for one, text in _HELP.items()),
            Gauge("robot_lost_messages", "Messages of one robot that did not arrive, as far as it lost any.",
                  self._of_robots, ("robot", "kind"), True),
        ]  # fmt: skip

    def _of_kinds(self, what: str) -> Any:
        return lambda: {kind.value: getattr(count, what) for kind, count in self._arrivals.by_kind().items()}

    def _of_robots(self) -> dict[tuple[str, ...], float]:
        lossy = [
            ((robot, kind.value), float(count.lost))
            for robot, kinds in self._arrivals.by_robot().items()
            for kind, count in kinds.items()
            if count.lost
        ]
        return dict(sorted(lossy, key=lambda one: -one[1])[:MOST_SERIES])

    def _robot(self, robot: str, kinds: dict[Any, Count]) -> dict[str, Any]:
        total = Count()
        for count in kinds.values():
            total.add(count)
        odd = {kind.value: self._told(one) for kind, one in kinds.items() if one.lost or one.twice or one.out_of_order}
        return {"id": robot, **self._told(total), "kinds": odd}

    def _told(self, count: Count) -> dict[str, Any]:
        at = None
        if count.lost_s is not None:
            at = self._clock.utc() - timedelta(seconds=max(0.0, self._clock.mono_s() - count.lost_s))
        sent = count.received + count.lost - count.late
        return {
            **{what: getattr(count, what) for what in _WHAT},
            "lost_share": round((count.lost - count.late) / sent, 6) if sent else None,
            "lost_utc": None if at is None else at.isoformat(timespec="seconds"),
        }


_HELP = {
    "received": "Numbered messages of robots that arrived.",
    "lost": "Numbered messages of robots that did not arrive within ten seconds.",
    "late": "Messages of robots that counted as lost and arrived after all.",
    "twice": "Messages of robots that arrived again.",
    "out_of_order": "Messages of robots that were overtaken by later ones.",
}
