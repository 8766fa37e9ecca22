"""Which parts of the installation the pages hear of."""

from __future__ import annotations

from hmi.app.chores import worth_telling

FELL = "2026-05-20T10:00:00.000+00:00"


def test_a_part_that_starts_for_the_first_time_is_not_called_down() -> None:
    assert worth_telling({"media": {"state": "starting"}, "broker": {"state": "ok"}}) == []


def test_what_fell_and_what_was_back_is_told_and_a_missing_stop_at_once() -> None:
    parts = {
        "media": {"state": "starting", "down_since_utc": FELL},
        "broker": {"state": "ok", "last_down": {"from_utc": FELL, "until_utc": FELL}},
        "stop": {"state": "starting"},
    }
    assert [(one["name"], one["state"]) for one in worth_telling(parts)] == [
        ("media", "starting"), ("broker", "ok"), ("stop", "starting"),
    ]  # fmt: skip
