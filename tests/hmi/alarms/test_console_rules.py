"""What goes wrong in the console itself becomes an alarm that says so."""

from __future__ import annotations

from dataclasses import replace
from datetime import UTC, datetime, timedelta
from typing import Any

import pytest

from hmi.ingest.supervision.console import ConsoleRules, Health

NOW = datetime(2026, 5, 20, 14, 0, tzinfo=UTC)
WELL = Health(is_broker_up=True, disk_free=(200_000_000_000, 0.5), utc=NOW)


def part(state: str = "ok", restarts: int = 0, **more: Any) -> dict[str, Any]:
    """Return what the keeper says of a part."""
    return {"state": state, "restarts": restarts, **more}


def codes(rules: ConsoleRules, health: Health, now_s: float = 0.0) -> list[str]:
    """Return what is found."""
    return [one.code + (f".{one.detail}" if one.detail else "") for one in rules.look(health, now_s)]


def test_a_console_that_is_well_has_no_alarm() -> None:
    assert codes(ConsoleRules(), replace(WELL, parts={"stop": part(), "broker": part()})) == []


@pytest.mark.parametrize(
    ("health", "code"),
    [
        (replace(WELL, is_broker_up=False), "broker-lost"),
        (replace(WELL, is_database_up=False), "database-down"),
        (replace(WELL, disk_free=(2_000_000_000, 0.02)), "disk-full"),
        (replace(WELL, disk_free=(500_000_000, 0.09)), "disk-full"),
        (replace(WELL, writers={"History": "disk is full"}), "records-lost.history"),
        (replace(WELL, late_s=5.5), "console-slow"),
        (replace(WELL, clock_jump_s=-3600.0), "clock-jumped"),
        (replace(WELL, audit_text="Entry 7 was changed."), "audit-broken"),
        (replace(WELL, parts={"stop": part("down")}), "gateway-down"),
    ],
)
def test_each_trouble_has_its_alarm(health: Health, code: str) -> None:
    assert codes(ConsoleRules(), health) == [code]


def test_a_console_that_starts_may_be_late_for_a_moment_later_it_is_told() -> None:
    rules = ConsoleRules()
    assert codes(rules, replace(WELL, late_s=1.5), 0) == []
    assert codes(rules, replace(WELL, late_s=1.5), 59) == []
    assert codes(rules, replace(WELL, late_s=1.5), 61) == ["console-slow"]


def test_a_large_disk_with_much_room_is_not_full_at_four_percent() -> None:
    assert codes(ConsoleRules(), replace(WELL, disk_free=(400_000_000_000, 0.04))) == []


def test_a_part_that_was_started_again_is_told_for_a_moment() -> None:
    rules = ConsoleRules()
    assert codes(rules, replace(WELL, parts={"broker": part()}), 0) == []
    assert codes(rules, replace(WELL, parts={"broker": part(restarts=1)}), 1) == ["part-restarted.broker"]
    assert codes(rules, replace(WELL, parts={"broker": part(restarts=1)}), 10) == []


def test_a_console_that_was_itself_started_again_says_so() -> None:
    down = {"until_utc": (NOW - timedelta(seconds=3)).isoformat()}
    assert codes(ConsoleRules(), replace(WELL, parts={"console": part(restarts=1, last_down=down)})) == [
        "part-restarted.console"
    ]
    old = {"until_utc": (NOW - timedelta(hours=3)).isoformat()}
    assert codes(ConsoleRules(), replace(WELL, parts={"stop": part(restarts=1, last_down=old)})) == []


def test_lost_messages_are_an_alarm_until_a_minute_went_well() -> None:
    rules = ConsoleRules()
    rules.trouble("ingest_overflow", "12 robot messages were lost.", 100.0)
    assert codes(rules, WELL, 130.0) == ["messages-lost.ingest-overflow"]
    assert codes(rules, WELL, 161.0) == []
