"""The subscription to the map at the broker: kept, looked after, and how its notifications get through."""

from __future__ import annotations

import logging
from collections.abc import Awaitable, Callable
from dataclasses import dataclass
from datetime import datetime

from backend_clients.ngsi.errors import NotFound
from backend_clients.ngsi.subscription import Subscription, Wanted
from backend_clients.ngsi.subscriptions import Subscriptions
from hmi.clock import Clock
from hmi.cloud.marker import TenantMoved

ENSURE_S = 300.0  # renewed, doubles deleted: asks for all subscriptions of the tenant
WATCH_S = 30.0  # one small question, since nobody tells us of a subscription that somebody deleted
IsOurs = Callable[[], Awaitable[bool]]
_DEAD = frozenset({"inactive", "expired"})
log = logging.getLogger(__name__)


@dataclass(slots=True)
class SubscriptionNews:
    """How the subscription at the broker is.

    Args:
        is_there: it was there when it was looked at last.
        lost: how often it was deleted, or switched off, behind our back since the start; ``lost_at`` the last time.
        how: what was done then, as in ``Kept``.
        untold: why the broker's last notification did not get here, empty if it did.
    """

    is_there: bool = False
    lost: int = 0
    lost_at: datetime | None = None
    how: str = ""
    untold: str = ""


class MapSubscription:
    """One subscription of this console; ``round`` is called by the mirror's task while the link is up.

    Args:
        wanted: what it asks for.
        is_ours: whether the tenant that answers now is ours; another one has no subscription of ours to miss.
    """

    def __init__(self, subscriptions: Subscriptions, wanted: Wanted, clock: Clock, is_ours: IsOurs) -> None:
        self._subscriptions, self._wanted, self._clock, self._is_ours = subscriptions, wanted, clock, is_ours
        self._id = ""
        self._ensure_s = self._watch_s = float("-inf")
        self.news = SubscriptionNews()

    def ensure_soon(self) -> None:
        """Make or adopt it in the next round: the broker may know nothing of it any more."""
        self._ensure_s = float("-inf")

    async def round(self) -> bool:
        """Look after it if it is time; return whether changes may have gone untold since the last look.

        Raises:
            NgsiError: it could not be asked.
            TenantMoved: another tenant answers; nothing was written there.
        """
        now_s = self._clock.mono_s()
        is_due = now_s >= self._ensure_s
        if not is_due and now_s >= self._watch_s:
            is_due = not await self._is_alive()
        self._watch_s = now_s + WATCH_S if now_s >= self._watch_s else self._watch_s
        if not is_due:
            return False
        is_lost = await self._ensure()
        self._ensure_s = now_s + ENSURE_S
        return is_lost

    async def _is_alive(self) -> bool:
        try:
            found = await self._subscriptions.get(self._id)
        except NotFound:
            return False
        self.news.untold = self._why_untold(found)
        return found.status not in _DEAD

    def _why_untold(self, found: Subscription) -> str:
        """Return why nothing gets here; the address has a secret in it, and goes on no screen."""
        if not found.fails and found.status != "failed":
            return ""
        secret = self._wanted.url.rpartition("/")[2]
        reason = found.last_failure_reason or "no reason given"
        return "its answer names this console's address" if secret in reason else reason

    async def _ensure(self) -> bool:
        if not await self._is_ours():
            raise TenantMoved
        kept, news = await self._subscriptions.ensure(self._wanted, self._clock.utc()), self.news
        is_lost = news.is_there and kept.how in ("made", "mended")
        if is_lost:
            news.lost, news.lost_at, news.how = news.lost + 1, self._clock.utc(), kept.how
            log.warning("the subscription at the broker was gone or off, and is %s again", kept.how)
        self._id, news.is_there = kept.id, True
        news.untold = "" if kept.how == "made" else news.untold
        return is_lost
