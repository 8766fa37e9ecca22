"""The robot's rules of freshness, lease and order; pure, no clock of its own, no I/O.

Nothing here compares wall clocks: an order proves its age by echoing a challenge that this robot
issued, and the robot looks up when that was on its own monotonic clock.
"""

from __future__ import annotations

from collections import OrderedDict, deque
from collections.abc import Callable

from backend_clients.simulator.verdict import OK, Verdict, refused

CHALLENGE_LIFE_S = 2.0  # ten heartbeats; longer would let an order act after an outage
REMEMBER_S = 60.0  # far longer than a challenge lives, so that no repeat can act twice
MAX_REMEMBERED = 4096


class Guard:
    """Judges orders; remembers challenges, the lease and the answers given.

    Args:
        make_challenge: returns a fresh unguessable string of 8 to 64 characters.
        lease_token: highest token seen before a reboot.
        revoked_token: tokens up to this one were ended by a STOP.
    """

    def __init__(self, make_challenge: Callable[[], str], *, lease_token: int = 0, revoked_token: int = 0) -> None:
        self._make_challenge = make_challenge
        self.lease_token = lease_token
        self.revoked_token = revoked_token
        self._order_seq = -1
        self._pulse_seq = -1
        self._challenges: deque[tuple[float, str]] = deque()
        self._answers: OrderedDict[str, tuple[float, Verdict]] = OrderedDict()

    @property
    def active_lease(self) -> int:
        """The token in force, 0 if none."""
        return self.lease_token if self.lease_token > self.revoked_token else 0

    def issue(self, now_s: float) -> str:
        """Return a new challenge for the heartbeat sent now."""
        challenge = self._make_challenge()
        self._challenges.append((now_s, challenge))
        self._forget_challenges(now_s)
        return challenge

    def answer_of(self, ref: str) -> Verdict | None:
        """Return the answer already given to this command or reset id, if any."""
        known = self._answers.get(ref)
        return known[1] if known is not None else None

    def can_remember(self, now_s: float) -> bool:
        """Say whether one more answer can be kept without forgetting one that still matters."""
        while self._answers:
            ref, (since_s, _) = next(iter(self._answers.items()))
            if now_s - since_s <= REMEMBER_S:
                break
            del self._answers[ref]
        return len(self._answers) < MAX_REMEMBERED

    def remember(self, ref: str, verdict: Verdict, now_s: float) -> None:
        """Keep the answer to an id, so that a repeat gets the same one and has no effect."""
        self._answers.setdefault(ref, (now_s, verdict))

    def judge_fresh(self, now_s: float, challenge: str, ttl_s: float, *, is_retained: bool) -> Verdict:
        """Judge an order that needs no lease (pause, abort)."""
        if is_retained:
            return refused("retained")
        age_s = self._age_s(now_s, challenge)
        if age_s is None:
            return refused("stale_challenge")
        if age_s > ttl_s:
            return refused("expired")
        return OK

    def judge_leased(
        self, now_s: float, challenge: str, ttl_s: float, token: int, seq: int, *, is_retained: bool
    ) -> Verdict:
        """Judge an order that can move the machine; an accepted one advances lease and sequence."""
        verdict = self.judge_fresh(now_s, challenge, ttl_s, is_retained=is_retained)
        if not verdict.is_accepted:
            return verdict
        verdict = self._judge_token(token)
        if not verdict.is_accepted:
            return verdict
        if token == self.lease_token and seq <= self._order_seq:
            return refused("out_of_order")
        self._adopt(token)
        self._order_seq = seq
        return OK

    def judge_pulse(self, now_s: float, challenge: str, token: int, seq: int, *, is_retained: bool) -> Verdict:
        """Judge an operator heartbeat; it has its own sequence since it orders nothing."""
        verdict = self.judge_fresh(now_s, challenge, CHALLENGE_LIFE_S, is_retained=is_retained)
        if not verdict.is_accepted:
            return verdict
        verdict = self._judge_token(token)
        if not verdict.is_accepted:
            return verdict
        if token == self.lease_token and seq <= self._pulse_seq:
            return refused("out_of_order")
        self._adopt(token)
        self._pulse_seq = seq
        return OK

    def revoke(self) -> None:
        """End the present lease; its token and all older ones are refused from now on."""
        self.revoked_token = max(self.revoked_token, self.lease_token)

    def _judge_token(self, token: int) -> Verdict:
        if token <= 0:
            return refused("no_lease")
        if token <= self.revoked_token:
            return refused("lease_revoked")
        if token < self.lease_token:
            return refused("old_lease")
        return OK

    def _adopt(self, token: int) -> None:
        if token > self.lease_token:
            self.lease_token = token
            self._order_seq = self._pulse_seq = -1

    def _age_s(self, now_s: float, challenge: str) -> float | None:
        self._forget_challenges(now_s)
        for issued_s, known in reversed(self._challenges):
            if known == challenge:
                return now_s - issued_s
        return None

    def _forget_challenges(self, now_s: float) -> None:
        while self._challenges and now_s - self._challenges[0][0] > CHALLENGE_LIFE_S:
            self._challenges.popleft()
