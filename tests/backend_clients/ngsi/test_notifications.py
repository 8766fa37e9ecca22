"""Notifications are read with distrust, and their order is found again."""

from __future__ import annotations

import json
from datetime import UTC, datetime, timedelta
from itertools import permutations
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import SecretStr

from backend_clients.ngsi import entity as make
from backend_clients.ngsi.entity import Entity
from backend_clients.ngsi.errors import BadInput, NgsiError, TooLong, Unreadable
from backend_clients.ngsi.gate import Gate
from backend_clients.ngsi.identifier import EntityRef
from backend_clients.ngsi.intake import Intake, Verdict
from backend_clients.ngsi.notification import MAX_BYTES, read_notification

NOW = datetime(2026, 5, 1, 12, tzinfo=UTC)
SECRET = "s" * 32


def said(seconds: float, speed: float, *, gone: bool = False, name: str = "r1") -> Entity:
    kind = "entityDelete" if gone else "entityChange"
    return Entity(
        ref=EntityRef(name, "Robot"),
        attributes={
            "speed": make.number(speed),
            "dateModified": make.date_time(NOW + timedelta(seconds=seconds)),
            "alterationType": make.text(kind),
        },
    )


def test_in_whatever_order_they_come_the_newest_is_kept_last() -> None:
    for order in permutations([said(-3, 1), said(-2, 2), said(-1, 3)]):
        intake, kept = Intake(), 0.0
        for entity in order:
            if intake.judge(entity, NOW) is Verdict.NEW:
                kept = entity.value("speed")  # type: ignore[assignment]
        assert kept == 3


def test_a_repeat_and_an_old_one_are_told_apart() -> None:
    intake = Intake()
    assert intake.judge(said(-1, 1), NOW) is Verdict.NEW
    assert intake.judge(said(-1, 1), NOW) is Verdict.REPEAT
    assert intake.judge(said(-2, 0), NOW) is Verdict.OLD
    assert intake.counts.by_verdict == {
        Verdict.NEW: 1, Verdict.REPEAT: 1, Verdict.OLD: 1, Verdict.UNCLEAR: 0, Verdict.GONE: 0
    }  # fmt: skip


def test_two_changes_in_one_millisecond_have_to_be_read_from_the_broker() -> None:
    intake = Intake()
    intake.judge(said(-1, 1), NOW)
    assert intake.judge(said(-1, 2), NOW) is Verdict.UNCLEAR


def test_a_source_ahead_of_us_blocks_nothing() -> None:
    intake = Intake()
    assert intake.judge(said(3600, 9), NOW) is Verdict.UNCLEAR
    assert intake.judge(said(-1, 1), NOW) is Verdict.NEW


def test_without_a_time_the_order_is_unclear() -> None:
    bare = Entity(ref=EntityRef("r1", "Robot"), attributes={"speed": make.number(1)})
    wrong = Entity(ref=EntityRef("r1", "Robot"), attributes={"dateModified": make.text("soon")})
    assert Intake().judge(bare, NOW) is Verdict.UNCLEAR
    assert Intake().judge(wrong, NOW) is Verdict.UNCLEAR


def test_what_is_gone_stays_gone_for_late_news_and_comes_back_when_made_anew() -> None:
    intake = Intake()
    intake.judge(said(-5, 1), NOW)
    assert intake.judge(said(-5, 1, gone=True), NOW) is Verdict.GONE
    assert intake.judge(said(-5, 1, gone=True), NOW) is Verdict.REPEAT
    assert intake.judge(said(-5, 1), NOW) is Verdict.OLD
    assert intake.judge(said(-1, 1), NOW) is Verdict.NEW


def test_the_sources_own_time_counts_before_the_brokers() -> None:
    intake = Intake(("dateObserved", "dateModified"))
    late = said(-1, 1)
    late.attributes["dateObserved"] = make.date_time(NOW - timedelta(hours=1))
    assert intake.source_time(late) == NOW - timedelta(hours=1)


def test_memory_is_bounded() -> None:
    intake = Intake(most=2)
    for name in ("a", "b", "c"):
        intake.judge(said(-1, 1, name=name), NOW)
    assert intake.judge(said(-1, 1, name="c"), NOW) is Verdict.REPEAT
    assert intake.judge(said(-1, 1, name="a"), NOW) is Verdict.NEW


SCALARS = st.none() | st.booleans() | st.sampled_from([0, -1.5, float("nan"), 1e308, "", "r1", "Robot", "\ud800"])
MEMBERS = st.sampled_from(["subscriptionId", "data", "id", "type", "value", "metadata", "x"])
CONTENT = st.recursive(
    SCALARS,
    lambda inner: st.lists(inner, max_size=2) | st.dictionaries(MEMBERS, inner, max_size=4),
    max_leaves=8,
)
ENTITY = st.fixed_dictionaries({"id": SCALARS, "type": SCALARS, "x": CONTENT})
POSTED = CONTENT | st.fixed_dictionaries({"subscriptionId": SCALARS, "data": st.lists(ENTITY, max_size=2)})


@given(st.binary(max_size=50) | POSTED.map(lambda value: json.dumps(value).encode()))
@settings(max_examples=60)
def test_nothing_that_is_posted_gets_further_than_an_error(body: bytes) -> None:
    try:
        found = read_notification(body, {})
    except NgsiError:
        return
    assert all(entity.ref.id is not None for entity in found.entities)


@pytest.mark.parametrize("body", [{}, {"subscriptionId": "a"}, {"subscriptionId": "a", "data": [{}]}, [], {"data": []}])
def test_what_is_no_notification_is_unreadable(body: Any) -> None:
    with pytest.raises(Unreadable):
        read_notification(json.dumps(body).encode(), {})


def test_another_format_or_a_huge_one_is_refused() -> None:
    with pytest.raises(Unreadable):
        read_notification(b"{}", {"ngsiv2-attrsformat": "keyValues"})
    with pytest.raises(TooLong):
        read_notification(b" " * (MAX_BYTES + 1), {})


def test_only_the_broker_with_the_secret_and_from_its_place_is_let_in() -> None:
    gate = Gate(SecretStr(SECRET), ["10.0.0.0/24", "127.0.0.1"])
    assert gate.lets_in(SECRET, "10.0.0.7")
    assert gate.lets_in(SECRET, "::ffff:10.0.0.7")
    assert not gate.lets_in(SECRET, "10.0.1.7")
    assert not gate.lets_in(SECRET, "somewhere")
    assert not gate.lets_in("x", "10.0.0.7")
    assert not gate.lets_in("ñ", "10.0.0.7")
    assert Gate(SecretStr(SECRET)).lets_in(SECRET, "192.0.2.1")


@pytest.mark.parametrize(("secret", "sources"), [("short", []), ("a/" * 20, []), (SECRET, ["farm"])])
def test_a_gate_that_would_not_hold_is_refused(secret: str, sources: list[str]) -> None:
    with pytest.raises(BadInput) as caught:
        Gate(SecretStr(secret), sources)
    assert secret not in str(caught.value) or secret == SECRET
