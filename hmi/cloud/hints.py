"""Notifications of the broker as hints: which entities to read. What they say is not believed: a storm costs little."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from backend_clients.ngsi.errors import NgsiError
from backend_clients.ngsi.gate import Gate
from backend_clients.ngsi.identifier import EntityRef
from backend_clients.ngsi.intake import Intake, Verdict
from backend_clients.ngsi.notification import read_notification
from backend_clients.ngsi.tenant import Tenant
from hmi.clock import Clock

MOST = 500  # entities remembered; with more of them everything is read
_NEWS = frozenset({Verdict.NEW, Verdict.UNCLEAR, Verdict.GONE})


@dataclass(slots=True)
class Counts:
    """Notifications since the start."""

    taken: int = 0
    refused: int = 0
    by_verdict: dict[str, int] = field(default_factory=dict)

    @property
    def old(self) -> int:
        """Repeated, or older than what was known; outside of a storm, where nobody looks."""
        return self.by_verdict.get(Verdict.REPEAT.value, 0) + self.by_verdict.get(Verdict.OLD.value, 0)


class Hints:
    """Takes notifications.

    Args:
        gate: lets the broker in and nobody else.
        tenant: whose notifications count.
    """

    def __init__(self, gate: Gate, tenant: Tenant, clock: Clock) -> None:
        self._gate, self._tenant, self._clock = gate, tenant, clock
        self._intake = Intake()
        self._waiting: dict[EntityRef, bool] = {}
        self.is_too_many = False
        self.counts = Counts()

    def lets_in(self, secret: str, source: str) -> bool:
        """Say whether a notification with this secret, from this address, is our broker's; ask before reading it."""
        is_known = self._gate.lets_in(secret, source)
        self.counts.refused += not is_known
        return is_known

    def take(self, body: bytes, headers: Mapping[str, str]) -> bool:
        """Take one notification that was let in; ``False``: it is of another tenant, or cannot be read."""
        if self.is_too_many:  # everything is read anyway: a storm is not even looked at
            self.counts.taken += 1
            return True
        try:
            found = read_notification(body, headers)
        except NgsiError:
            self.counts.refused += 1
            return False
        if (found.service, found.path) != (self._tenant.service, self._tenant.path):
            self.counts.refused += 1
            return False
        self.counts.taken += 1
        for entity in found.entities:
            verdict = self._intake.judge(entity, self._clock.utc())
            self.counts.by_verdict[verdict.value] = self.counts.by_verdict.get(verdict.value, 0) + 1
            if verdict in _NEWS:
                self._remember(entity.ref, is_gone=verdict is Verdict.GONE)
        return True

    def waiting(self) -> dict[EntityRef, bool]:
        """Return which entities to look at, and whether they are said to be deleted; they are forgotten here."""
        found, self._waiting = self._waiting, {}
        return found

    def _remember(self, ref: EntityRef, *, is_gone: bool) -> None:
        if len(self._waiting) >= MOST and ref not in self._waiting:
            self.is_too_many = True
            return
        self._waiting[ref] = is_gone
