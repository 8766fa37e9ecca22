"""Growing delays after wrong tries, per person and per address, in tables that cannot grow without end.

A try is counted before it is checked, so that a thousand tries sent at once are a thousand tries, not one.
"""

from __future__ import annotations

import ipaddress
from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass

CAPACITY = 10_000  # keys; when full, the one that was quiet longest is forgotten


@dataclass(frozen=True, slots=True)
class DelayRule:
    """``free_tries`` cost nothing; then the wait starts at ``first_wait_s`` and doubles up to ``longest_wait_s``."""

    free_tries: int
    first_wait_s: float
    longest_wait_s: float
    forget_s: float


PASSWORD_RULE = DelayRule(free_tries=3, first_wait_s=1.0, longest_wait_s=300.0, forget_s=3600.0)
# Many people may sit behind one address, so it gets more tries; guessing at scale still becomes hopeless.
ADDRESS_RULE = DelayRule(free_tries=20, first_wait_s=1.0, longest_wait_s=60.0, forget_s=900.0)
# 10,000 PINs, five tries, then a quarter of an hour and doubling: a thief needs years, a password always works.
PIN_RULE = DelayRule(free_tries=5, first_wait_s=900.0, longest_wait_s=86_400.0, forget_s=2 * 86_400.0)


class Blocked(Exception):
    """Too many wrong tries; ``wait_s`` is left."""

    def __init__(self, wait_s: float) -> None:
        super().__init__(f"blocked for {wait_s:.0f} s")
        self.wait_s = wait_s


@dataclass(slots=True)
class _Record:
    tries: int
    last_s: float
    blocked_until_s: float


class Lockout:
    """Counts wrong tries by key. Used on the event loop; never waits."""

    def __init__(self, rule: DelayRule, mono_s: Callable[[], float], capacity: int = CAPACITY) -> None:
        self._rule = rule
        self._mono_s = mono_s
        self._capacity = capacity
        self._records: OrderedDict[str, _Record] = OrderedDict()

    def begin(self, key: str) -> None:
        """Count a try that is about to be made.

        Raises:
            Blocked: it may not be made; it was not counted.
        """
        now_s = self._mono_s()
        record = self._current(key, now_s)
        if now_s < record.blocked_until_s:
            raise Blocked(record.blocked_until_s - now_s)
        record.tries += 1
        record.last_s = now_s
        record.blocked_until_s = now_s + self._wait_s(record.tries)

    def succeed(self, key: str) -> None:
        """Forget the wrong tries of ``key``: the right secret was given."""
        self._records.pop(key, None)

    def take_back(self, key: str) -> None:
        """Uncount a try that was right or could not be checked, without forgetting the others."""
        record = self._records.get(key)
        if record is not None:
            record.tries = max(0, record.tries - 1)
            record.blocked_until_s = record.last_s + self._wait_s(record.tries)

    def tries_left(self, key: str) -> int:
        """Return how many tries cost nothing yet."""
        record = self._records.get(key)
        return self._rule.free_tries if record is None else max(0, self._rule.free_tries - record.tries)

    def _wait_s(self, tries: int) -> float:
        over = tries - self._rule.free_tries
        return 0.0 if over < 0 else min(self._rule.first_wait_s * 2.0 ** min(over, 60), self._rule.longest_wait_s)

    def _current(self, key: str, now_s: float) -> _Record:
        record = self._records.get(key)
        if record is None or now_s - record.last_s > self._rule.forget_s:
            record = self._records[key] = _Record(0, now_s, 0.0)
        self._records.move_to_end(key)
        while len(self._records) > self._capacity:
            self._records.popitem(last=False)
        return record


def address_key(address: str) -> str:
    """Return what counts as one address: an IPv6 customer has a whole /64."""
    try:
        parsed = ipaddress.ip_address(address)
    except ValueError:
        return address[:64]
    if isinstance(parsed, ipaddress.IPv6Address):
        if parsed.ipv4_mapped is not None:
            return str(parsed.ipv4_mapped)
        return str(ipaddress.IPv6Network((parsed, 64), strict=False))
    return str(parsed)
