"""How the cloud is, for the panel, the alarms and health."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from hmi.clock import Clock
from hmi.cloud.backlog import Backlog
from hmi.cloud.delays import Delay, Delays
from hmi.cloud.link_state import DELIVERS, NEEDS_ADMIN, LinkState
from hmi.cloud.mirror import Mirror
from hmi.cloud.proposals import ProposalBook
from hmi.domain.alarm.finding import MAX_TEXT, Finding, Findings
from hmi.presenters.cloud import words_of
from hmi.settings import Settings

PUBLISHED_MEAN_S = 0.25  # robot to context broker in the published system, to compare with
LOST_SHOWN_S = 600.0
Heard = Callable[[], Mapping[str, int]]
"""What went wrong on the way from the robots, reason -> how often; see ``hmi.ingest.tally``."""


class CloudReport:
    """Gathers what is known of the link; cheap, asked every few seconds while somebody looks.

    Args:
        missions: delays of missions that were read back through the cloud.
        heard: counts of the way from the robots.
    """

    def __init__(
        self,
        settings: Settings,
        clock: Clock,
        mirror: Mirror,
        backlog: Backlog,
        book: ProposalBook,
        missions: Delays,
        heard: Heard,
    ) -> None:
        self._settings, self._clock, self._mirror, self._backlog = settings, clock, mirror, backlog
        self._book, self._missions, self._heard = book, missions, heard
        self._lost_seen = (0, float("-inf"))

    def findings(self) -> Findings:
        """Return what is wrong with the link for the alarms."""
        link, waiting, found = self._mirror.link.link, self._backlog.waiting, []
        words = words_of(link.state.value)
        text = f"{words.head}: {link.why}" if link.why else words.head
        if link.state in NEEDS_ADMIN:
            found.append(Finding("cloud-refused", text[:MAX_TEXT], since_s=link.since_s))
        elif link.state not in DELIVERS:
            found.append(Finding("cloud-away", f"{text} {waiting.count} records wait."[:MAX_TEXT]))
        count, seen_s = self._lost_seen
        if waiting.lost > count:
            self._lost_seen = count, seen_s = waiting.lost, self._clock.mono_s()
        if self._clock.mono_s() - seen_s < LOST_SHOWN_S or waiting.trouble:
            found.append(Finding("cloud-dropped", waiting.trouble[:MAX_TEXT] or f"{waiting.lost} since the start."))
        return tuple(found)

    def health(self) -> dict[str, dict[str, Any]]:
        """Return the part of the cloud for ``/api/v1/health``; a cloud that is away makes nothing else worse."""
        state = self._mirror.link.link.state
        return {"cloud": {"state": "degraded" if state in NEEDS_ADMIN else "ok", "url": self._settings.cloud_url}}

    def whole(self) -> dict[str, Any]:
        """Return everything the panel shows."""
        mirror = self._mirror
        link, now_s = mirror.link.link, self._clock.mono_s()
        words, heard = words_of(link.state.value), mirror.link.heard_at
        return {
            "state": link.state.value,
            "head": words.head,
            "text": words.text,
            "level": words.level,
            "why": link.why,
            "mend": link.mend,
            "for_s": round(now_s - link.since_s, 1),
            "url": self._settings.cloud_url,
            "tenant": self._settings.cloud_tenant,
            "path": self._settings.cloud_path,
            "heard_utc": None if heard is None else heard.isoformat(timespec="milliseconds"),
            "skew_s": mirror.link.skew_s,
            "can_take_tenant": link.state in (LinkState.OTHER_TENANT, LinkState.OTHER_CONSOLE),
            "waiting": self._waiting(),
            "map": self._map_report(),
            "delays": {
                "robot_console": _delay(mirror.to_console.told()),
                "robot_cloud": _delay(mirror.to_cloud.told()),
                "mission": _delay(self._missions.told()),
                "published_mean_s": PUBLISHED_MEAN_S,
            },
            "counts": {
                "states": mirror.counts.states,
                "records": mirror.counts.pieces,
                "sent_twice": mirror.counts.resent,
                "refused": mirror.counts.refused,
                "last_refusal": mirror.counts.last_refusal,
                "dropped": self._backlog.waiting.lost,
                "heard_twice": self._heard().get("repeated", 0),
                "lost_from_robots": self._heard().get("overflow", 0),
            },
        }

    def _map_report(self) -> dict[str, Any]:
        changes = self._mirror.changes
        hints = changes.hints if changes is not None else None
        return {
            "proposals": len(self._book.all()),
            "left_out": self._book.left_out,
            "subscribed": bool(changes and changes.subscribed),
            "notifications": 0 if hints is None else hints.counts.taken,
            "notifications_refused": 0 if hints is None else hints.counts.refused,
        }

    def _waiting(self) -> dict[str, Any]:
        waiting, now = self._backlog.waiting, self._clock.utc().timestamp()
        age_s = None if waiting.oldest_s is None else round(max(0.0, now - waiting.oldest_s), 1)
        return {
            "count": self._backlog.total,
            "bytes": waiting.bytes,
            "limit_bytes": self._settings.cloud_outbox_mb * 2**20,
            "oldest_age_s": age_s,
            "trouble": waiting.trouble,
        }


def _delay(found: Delay) -> dict[str, float | int | None]:
    def shown(value: float | None) -> float | None:
        return None if value is None else round(value, 4)

    return {"mean_s": shown(found.mean_s), "p50_s": shown(found.p50_s), "p99_s": shown(found.p99_s),
            "count": found.count}  # fmt: skip
