"""Lockout: the wait grows, tries sent at once all count, tables stay small."""

from __future__ import annotations

import contextlib

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hmi.clock import FakeClock
from hmi.security.lockout import PIN_RULE, Blocked, DelayRule, Lockout, address_key

RULE = DelayRule(free_tries=3, first_wait_s=1.0, longest_wait_s=60.0, forget_s=600.0)


@given(st.lists(st.floats(0, 400), max_size=60))
def test_tries_never_come_faster_than_the_rule(pauses: list[float]) -> None:
    clock = FakeClock()
    lockout = Lockout(RULE, clock.mono_s)
    passed: list[float] = []
    waits: list[float] = []
    for pause in pauses:
        clock.advance(pause)
        try:
            lockout.begin("martha")
        except Blocked as blocked:
            waits.append(blocked.wait_s)
        else:
            passed.append(clock.mono_s())
    assert all(0 < wait_s <= RULE.longest_wait_s for wait_s in waits)
    for index in range(3, len(passed)):
        since_free = index - 3
        assert passed[index] - passed[index - 1] >= min(2.0**since_free, 60.0) - 1e-9


@given(st.floats(0, 1e6), st.integers(1, 30))
def test_after_the_wait_one_try_is_always_possible(start_s: float, wrong_tries: int) -> None:
    clock = FakeClock()
    clock.advance(start_s)
    lockout = Lockout(RULE, clock.mono_s)
    for _ in range(wrong_tries):
        try:
            lockout.begin("martha")
        except Blocked as blocked:
            clock.advance(blocked.wait_s + 1e-6)
            lockout.begin("martha")


def test_a_thousand_pins_sent_at_once_are_a_thousand_tries() -> None:
    lockout = Lockout(PIN_RULE, FakeClock().mono_s)
    passed = 0
    for _ in range(1000):
        try:
            lockout.begin("martha")
            passed += 1
        except Blocked:
            pass
    assert passed == 5


def test_success_forgets_and_taking_back_forgets_one() -> None:
    lockout = Lockout(RULE, FakeClock().mono_s)
    for _ in range(3):
        lockout.begin("martha")
    assert lockout.tries_left("martha") == 0
    lockout.take_back("martha")
    assert lockout.tries_left("martha") == 1
    lockout.begin("martha")
    lockout.succeed("martha")
    assert lockout.tries_left("martha") == 3


def test_old_tries_are_forgotten() -> None:
    clock = FakeClock()
    lockout = Lockout(RULE, clock.mono_s)
    for _ in range(3):
        lockout.begin("martha")
    clock.advance(601)
    lockout.begin("martha")
    assert lockout.tries_left("martha") == 2


def test_the_table_is_bounded_and_keeps_who_tries_now() -> None:
    lockout = Lockout(RULE, FakeClock().mono_s, capacity=100)
    for number in range(10_000):
        lockout.begin(f"name-{number}")
        if number % 50 == 0:
            with contextlib.suppress(Blocked):
                lockout.begin("martha")
    assert lockout.tries_left("martha") == 0
    assert [lockout.tries_left(f"name-{number}") for number in (9_800, 9_999)] == [3, 2]


@pytest.mark.parametrize(
    ("address", "key"),
    [
        ("192.168.1.20", "192.168.1.20"),
        ("::ffff:192.168.1.20", "192.168.1.20"),
        ("2001:db8:1:2:3:4:5:6", "2001:db8:1:2::/64"),
        ("testclient", "testclient"),
    ],
)
def test_an_ipv6_customer_is_one_address(address: str, key: str) -> None:
    assert address_key(address) == key
