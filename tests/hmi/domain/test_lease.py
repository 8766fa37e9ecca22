"""Control leases: one holder, tokens that only grow, nothing that outlives its proof of life."""

from __future__ import annotations

import pytest
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, rule

from hmi.domain.lease import ASK_TTL_S, MAX_ASKS, TTL_S, Holder, Lease, LeaseBook, LeaseCode

ROBOT = "weeder-01"


def holder(name: str) -> Holder:
    """Return a browser of somebody."""
    return Holder(name, name, name.title(), "Tablet 1")


def held(book: LeaseBook, name: str, now_s: float = 0.0) -> Lease:
    """Let somebody take a free robot."""
    answer = book.request(ROBOT, holder(name), now_s)
    assert answer.code is LeaseCode.GRANTED
    assert answer.lease is not None
    return answer.lease


def test_a_free_robot_is_granted_at_once() -> None:
    lease = held(LeaseBook(3), "martha")
    assert lease.token == 3 << 20 | 1
    assert lease.holder.user_name == "Martha"


def test_asking_for_a_held_robot_makes_one_wait_once() -> None:
    book = LeaseBook(1)
    held(book, "martha")
    for _ in range(3):
        assert book.request(ROBOT, holder("jonas"), 1.0).code is LeaseCode.ASKED
    lease = book.of(ROBOT, 1.0)
    assert lease is not None
    assert [a.holder.user_name for a in lease.open_asks(1.0)] == ["Jonas"]


def test_the_holder_gives_control_to_who_asked_and_to_nobody_else() -> None:
    book = LeaseBook(1)
    mine = held(book, "martha")
    assert book.grant(ROBOT, "martha", "jonas", 0.0).code is LeaseCode.NOBODY_ASKS
    book.request(ROBOT, holder("jonas"), 0.0)
    book.request(ROBOT, holder("anna"), 0.0)
    assert book.grant(ROBOT, "jonas", "jonas", 0.0).code is LeaseCode.NOT_HOLDER
    answer = book.grant(ROBOT, "martha", "jonas", 1.0)
    assert answer.ended is not None
    assert answer.ended.token == mine.token
    assert answer.lease is not None
    assert answer.lease.token > mine.token
    assert answer.lease.holder.user_name == "Jonas"
    assert [a.holder.user_name for a in answer.lease.asks] == ["Anna"]


def test_keeping_control_sends_the_asker_away() -> None:
    book = LeaseBook(1)
    held(book, "martha")
    book.request(ROBOT, holder("jonas"), 0.0)
    answer = book.keep(ROBOT, "martha", None, 0.0)
    assert answer.code is LeaseCode.KEPT
    assert answer.lease is not None
    assert answer.lease.asks == ()


def test_who_asked_long_ago_is_not_handed_a_robot() -> None:
    book = LeaseBook(1)
    held(book, "martha")
    book.request(ROBOT, holder("jonas"), 0.0)
    for second in range(int(ASK_TTL_S) + 1):
        book.renew(ROBOT, "martha", float(second))
    assert book.grant(ROBOT, "martha", None, ASK_TTL_S).code is LeaseCode.NOBODY_ASKS


def test_asking_for_a_robot_has_a_limit() -> None:
    book = LeaseBook(1)
    held(book, "martha")
    for number in range(MAX_ASKS):
        book.request(ROBOT, holder(f"person{number}"), 0.0)
    assert book.request(ROBOT, holder("one-more"), 0.0).code is LeaseCode.TOO_MANY_ASK
    assert book.request(ROBOT, holder("person3"), 0.0).code is LeaseCode.ASKED


def test_a_holder_that_falls_silent_loses_the_robot() -> None:
    book = LeaseBook(1)
    mine = held(book, "martha")
    assert book.renew(ROBOT, "martha", 9.5) is not None
    assert book.of(ROBOT, 9.5 + TTL_S) is None
    assert book.renew(ROBOT, "martha", 9.5 + TTL_S) is None
    [ended] = book.expire(9.5 + TTL_S)
    assert ended.token == mine.token
    assert book.expire(9.5 + TTL_S) == ()


def test_taking_ends_the_other_lease_and_taking_ones_own_changes_nothing() -> None:
    book = LeaseBook(1)
    mine = held(book, "martha")
    taken = book.take(ROBOT, holder("anna"), 1.0)
    assert taken.ended == mine
    again = book.take(ROBOT, holder("anna"), 2.0)
    assert again.ended is None
    assert again.lease is not None
    assert taken.lease is not None
    assert again.lease.token == taken.lease.token


def test_another_browser_of_the_same_person_is_another_holder() -> None:
    book = LeaseBook(1)
    book.request(ROBOT, Holder("browser-1", "martha", "Martha", ""), 0.0)
    assert book.acquire_free(ROBOT, Holder("browser-2", "martha", "Martha", ""), 0.0).code is LeaseCode.HELD_BY_OTHER


def test_signing_out_gives_back_what_was_held_and_asked_for() -> None:
    book = LeaseBook(1)
    held(book, "martha")
    book.request("weeder-02", holder("jonas"), 0.0)
    book.request("weeder-02", holder("martha"), 0.0)
    [ended] = book.end_session("martha", 0.0)
    assert ended.robot_id == ROBOT
    other = book.of("weeder-02", 0.0)
    assert other is not None
    assert other.asks == ()


def test_order_numbers_begin_anew_with_each_token_and_end_with_it() -> None:
    book = LeaseBook(1)
    mine = held(book, "martha")
    assert [book.next_seq(mine) for _ in range(3)] == [1, 2, 3]
    theirs = book.take(ROBOT, holder("anna"), 1.0).lease
    assert theirs is not None
    assert book.next_seq(mine) == 4
    assert book.next_seq(theirs) == 1
    book.forget(mine)
    with pytest.raises(ValueError, match="is over"):
        book.next_seq(mine)


def test_tokens_of_a_later_start_are_higher_than_any_before() -> None:
    before = LeaseBook(7)
    tokens = [before.take(ROBOT, holder(f"p{n}"), 0.0).lease for n in range(50)]
    after = held(LeaseBook(8), "martha")
    assert all(lease is not None and lease.token < after.token for lease in tokens)


def test_an_epoch_that_is_used_up_gives_no_more_tokens_until_the_next() -> None:
    book = LeaseBook(1)
    book._grants = (1 << 20) - 2  # a million grants take too long here
    assert book.is_low_on_tokens
    last = held(book, "martha")
    assert book.take(ROBOT, holder("anna"), 0.0).code is LeaseCode.NO_TOKENS
    assert book.of(ROBOT, 0.0) == last
    book.begin_epoch(2)
    assert not book.is_low_on_tokens
    fresh = book.take(ROBOT, holder("anna"), 0.0).lease
    assert fresh is not None
    assert fresh.token > last.token
    with pytest.raises(ValueError, match="does not follow"):
        book.begin_epoch(2)


PEOPLE = st.sampled_from(["martha", "jonas", "anna"])
ROBOTS = st.sampled_from(["weeder-01", "weeder-02"])


class Leases(RuleBasedStateMachine):
    """Any number of people, robots, restarts and waits."""

    @initialize()
    def start(self) -> None:
        """Begin with a console that was just started."""
        self.epoch = 1
        self.book = LeaseBook(self.epoch)
        self.now_s = 0.0
        self.highest: dict[str, int] = {}
        self.alive_s: dict[tuple[str, str], float] = {}

    @rule(seconds=st.floats(0, 12))
    def wait(self, seconds: float) -> None:
        """Let time pass."""
        self.now_s += seconds

    @rule(robot=ROBOTS, person=PEOPLE, op=st.sampled_from(["request", "acquire_free", "take"]))
    def want(self, robot: str, person: str, op: str) -> None:
        """Ask for, acquire or take a robot."""
        before = self.book.of(robot, self.now_s)
        answer = getattr(self.book, op)(robot, holder(person), self.now_s)
        if answer.code is LeaseCode.GRANTED:
            self.note(robot, answer.lease, before)
            if op != "take":
                assert before is None or before.holder.session_id == person
        else:
            assert before is not None
            assert answer.lease is not None
            assert answer.lease.token == before.token

    @rule(robot=ROBOTS, person=PEOPLE)
    def give(self, robot: str, person: str) -> None:
        """Hand over to whoever asked first."""
        before = self.book.of(robot, self.now_s)
        answer = self.book.grant(robot, person, None, self.now_s)
        if answer.code is LeaseCode.GRANTED:
            assert before is not None
            assert before.holder.session_id == person
            self.note(robot, answer.lease, before)

    @rule(robot=ROBOTS, person=PEOPLE)
    def prove_life(self, robot: str, person: str) -> None:
        """Renew."""
        before = self.book.of(robot, self.now_s)
        renewed = self.book.renew(robot, person, self.now_s)
        assert (renewed is not None) == (before is not None and before.holder.session_id == person)
        if renewed is not None:
            self.alive_s[robot, person] = self.now_s

    @rule(robot=ROBOTS, person=PEOPLE)
    def release(self, robot: str, person: str) -> None:
        """Give back, or stop asking."""
        self.book.release(robot, person, self.now_s)
        lease = self.book.of(robot, self.now_s)
        assert lease is None or lease.holder.session_id != person

    @rule(robot=ROBOTS)
    def stop(self, robot: str) -> None:
        """Revoke."""
        self.book.revoke(robot)
        assert self.book.of(robot, self.now_s) is None

    @rule()
    def expire(self) -> None:
        """Sweep."""
        for lease in self.book.expire(self.now_s):
            assert self.now_s - lease.renewed_s >= TTL_S

    @rule()
    def restart(self) -> None:
        """Start the console again."""
        self.epoch += 1
        self.book = LeaseBook(self.epoch)

    @invariant()
    def nobody_holds_without_a_sign_of_life(self) -> None:
        """Whoever holds a robot proved life, or was granted it, within the time to live."""
        for robot in ("weeder-01", "weeder-02"):
            lease = self.book.of(robot, self.now_s)
            if lease is not None:
                assert self.now_s - self.alive_s[robot, lease.holder.session_id] < TTL_S
                assert lease.token == self.highest[robot]

    def note(self, robot: str, lease: Lease | None, before: Lease | None) -> None:
        """Remember a grant; its token is higher than any before unless it is the same lease."""
        assert lease is not None
        if before is None or lease.token != before.token:
            assert lease.token > self.highest.get(robot, 0)
        self.highest[robot] = lease.token
        if before is None or lease.token != before.token or lease.renewed_s == self.now_s:
            self.alive_s[robot, lease.holder.session_id] = self.now_s


TestLeases = Leases.TestCase
TestLeases.settings = settings(max_examples=50, stateful_step_count=30, deadline=None)
