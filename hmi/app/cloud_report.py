"""How the cloud is, for the panel, the alarms and health."""

from __future__ import annotations

from datetime import UTC, datetime
from typing import Any

from hmi.app.arrival_report import FromRobots
from hmi.app.service_report import broker_findings, link_report, waits
from hmi.clock import Clock
from hmi.cloud.backlog import Backlog
from hmi.cloud.delays import Delay, Delays
from hmi.cloud.map_subscription import SubscriptionNews
from hmi.cloud.mirror import Mirror
from hmi.cloud.proposals import ProposalBook
from hmi.domain.alarm.finding import MAX_TEXT, Finding, Findings
from hmi.presenters.cloud import PARTLY, PARTLY_MEND, words_of
from hmi.service_link import MAX_WHY, NEEDS_PERSON, NOT_OURS
from hmi.settings import Settings

PUBLISHED_MEAN_S = 0.25  # robot to context broker in the published system, to compare with
LOST_SHOWN_S = 600.0
BEHIND_S = 300.0  # robots and events go up within seconds; five minutes of them is nobody's jitter
MOST_REFUSED_SHOWN = 50


class CloudReport:
    """Gathers what is known of the link; cheap, asked every few seconds while somebody looks.

    Args:
        missions: delays of missions that were read back through the cloud.
        robots: how the way from the robots is.
    """

    def __init__(
        self,
        settings: Settings,
        clock: Clock,
        mirror: Mirror,
        backlog: Backlog,
        book: ProposalBook,
        missions: Delays,
        robots: FromRobots,
    ) -> None:
        self._settings, self._clock, self._mirror, self._backlog = settings, clock, mirror, backlog
        self._book, self._missions, self._robots = book, missions, robots
        self._lost_seen = (0, float("-inf"))

    def findings(self) -> Findings:
        """Return what is wrong with the link for the alarms."""
        return (
            *broker_findings(self._mirror.link.link, self._backlog.total),
            *self._stuck(),
            *self._behind(),
            *self._not_taken(),
            *self._dropped(),
        )

    def _stuck(self) -> Findings:
        text = self._stuck_text
        return (Finding("cloud-stuck", text[:MAX_TEXT]),) if text else ()

    def _behind(self) -> Findings:
        """Return that the broker answers and does not keep up; while it is away, that is the alarm."""
        link, age_s = self._mirror.link.link, self._oldest_age_s
        if not link.is_well or age_s is None or age_s < BEHIND_S:
            return ()
        text = f"{waits(self._backlog.total)} The oldest is {age_s / 60:.0f} min old. {link.why}".strip()
        return (Finding("cloud-behind", text[:MAX_TEXT]),)

    @property
    def _oldest_age_s(self) -> float | None:
        oldest_s = self._backlog.oldest_s
        return None if oldest_s is None else max(0.0, self._clock.utc().timestamp() - oldest_s)

    @property
    def _stuck_text(self) -> str:
        """What does not go up though the link is well; while it is not, nobody tries, so nobody knows."""
        return self._mirror.guard.text if self._mirror.link.link.is_well else ""

    def _dropped(self) -> Findings:
        waiting, (count, seen_s) = self._backlog.waiting, self._lost_seen
        if self._lost > count:
            self._lost_seen = count, seen_s = self._lost, self._clock.mono_s()
        found = []
        if waiting.trouble:
            in_memory = max(0, self._backlog.total - waiting.count)
            found.append(Finding("cloud-unkept", f"{waiting.trouble}. {waits(in_memory)}"[:MAX_TEXT]))
        if self._clock.mono_s() - seen_s < LOST_SHOWN_S:
            found.append(Finding("cloud-dropped", f"{self._lost} dropped since the start."))
        return tuple(found)

    @property
    def _lost(self) -> int:
        return self._backlog.waiting.lost + self._mirror.refused.dropped

    def _not_taken(self) -> Findings:
        records, others = len(self._mirror.refused.all()), len(self._mirror.not_taken)
        if not records + others:
            return ()
        parts = [_number(records, "record", "records"), _number(others, "entity", "entities")]
        text = " and ".join(part for part in parts if part) + (" is" if records + others == 1 else " are")
        last = self._mirror.counts.last_refusal
        return (
            Finding(
                "cloud-not-taken", f"{text} refused by the cloud{f', the last: {last}' if last else ''}"[:MAX_TEXT]
            ),
        )

    def health(self) -> dict[str, dict[str, Any]]:
        """Return the part of the cloud for ``/api/v1/health``; a cloud that is away makes nothing else worse."""
        is_degraded = self._mirror.link.link.state in NEEDS_PERSON or bool(self._stuck_text)
        return {"cloud": {"state": "degraded" if is_degraded else "ok", "url": self._settings.cloud_url}}

    def whole(self) -> dict[str, Any]:
        """Return everything the panel shows."""
        mirror = self._mirror
        link = mirror.link.link
        return {
            **link_report(link, words_of(link.state.value), self._clock),
            **self._partly(),
            "url": self._settings.cloud_url,
            "tenant": self._settings.cloud_tenant,
            "path": self._settings.cloud_path,
            "can_take_tenant": link.state in NOT_OURS,
            "waiting": self._waiting(),
            "refused": self._refused(),
            "map": self._map_report(),
            "delays": {
                "robot_console": _delay(mirror.to_console.told()),
                "robot_cloud": _delay(mirror.to_cloud.told()),
                "mission": _delay(self._missions.told()),
                "published_mean_s": PUBLISHED_MEAN_S,
            },
            "arrivals": self._robots.arrivals(),
            "counts": {
                "states": mirror.counts.states,
                "others": mirror.counts.others,
                "records": mirror.counts.pieces,
                "sent_twice": mirror.counts.resent,
                "refused": mirror.counts.refused,
                "last_refusal": mirror.counts.last_refusal,
                "dropped": self._lost,
                "heard_twice": self._robots.refused().get("repeated", 0),
                "lost_from_robots": self._robots.refused().get("overflow", 0),
            },
        }

    def _partly(self) -> dict[str, Any]:
        """Return what stands in the place of ``Connected`` while something does not go up."""
        why = self._stuck_text
        if not why:
            return {}
        return {**PARTLY._asdict(), "why": why[:MAX_WHY], "mend": PARTLY_MEND}

    def _map_report(self) -> dict[str, Any]:
        changes = self._mirror.changes
        hints = changes.hints if changes is not None else None
        kept = changes.subscription if changes is not None else None
        news = SubscriptionNews() if kept is None else kept.news
        return {
            "proposals": len(self._book.all()),
            "left_out": self._book.left_out,
            "is_told": hints is not None,
            "subscribed": news.is_there,
            "untold": news.untold,
            "subscription_lost": news.lost,
            "subscription_lost_utc": _moment(news.lost_at),
            "is_storm": hints is not None and hints.is_too_many,
            "old_news": 0 if hints is None else hints.counts.old,
            "notifications": 0 if hints is None else hints.counts.taken,
            "notifications_refused": 0 if hints is None else hints.counts.refused,
        }

    def _refused(self) -> dict[str, Any]:
        """Return what the broker would not take: records, which are kept, and what is told anew when it changes."""
        refused = self._mirror.refused
        rows = [
            {"id": one.ref.id, "type": one.ref.type, "why": one.why, "is_kept": True, "bytes": one.piece.size,
             "utc": _moment(datetime.fromtimestamp(one.refused_s, UTC)),
             "happened_utc": _moment(datetime.fromtimestamp(one.piece.at_s, UTC))}
            for one in refused.all()[:MOST_REFUSED_SHOWN]
        ]  # fmt: skip
        rows += [
            {"id": ref.id, "type": ref.type, "why": one.why, "is_kept": False, "bytes": None, "utc": _moment(one.at),
             "happened_utc": None}
            for ref, one in list(self._mirror.not_taken.items())[: -MOST_REFUSED_SHOWN - 1 : -1]
        ]  # fmt: skip
        count = len(refused.all()) + len(self._mirror.not_taken)
        return {
            "records": len(refused.all()),
            "rows": rows,
            "more": count - len(rows),
            "is_sending": bool(refused.again),
        }

    def _waiting(self) -> dict[str, Any]:
        waiting, age_s = self._backlog.waiting, self._oldest_age_s
        return {
            "count": self._backlog.total,
            "bytes": self._backlog.bytes,
            "limit_bytes": self._settings.cloud_outbox_mb * 2**20,
            "oldest_age_s": None if age_s is None else round(age_s, 1),
            "trouble": waiting.trouble,
        }


def _number(count: int, one: str, many: str) -> str:
    return f"{count} {one if count == 1 else many}" if count else ""


def _moment(at: datetime | None) -> str | None:
    return None if at is None else at.isoformat(timespec="milliseconds")


def _delay(found: Delay) -> dict[str, float | int | None]:
    def shown(value: float | None) -> float | None:
        return None if value is None else round(value, 4)

    return {"mean_s": shown(found.mean_s), "p50_s": shown(found.p50_s), "p99_s": shown(found.p99_s),
            "count": found.count}  # fmt: skip
