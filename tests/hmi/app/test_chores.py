"""Which parts of the installation the pages hear of, and what agrees with the database every few seconds."""

from __future__ import annotations

import asyncio
from types import SimpleNamespace
from typing import Any, cast

from hmi.app.chores import Chores, worth_telling
from hmi.clock import FakeClock

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


async def test_who_may_do_what_is_agreed_with_everywhere_once_the_sessions_are() -> None:
    done: list[str] = []
    freed = asyncio.Event()

    async def reconcile() -> None:
        done.append("sessions")

    async def free() -> None:
        done.append("duty")
        freed.set()

    async def forget_old() -> None:
        return None

    sessions = SimpleNamespace(reconcile=reconcile, sweep=lambda: None, forget_old=forget_old)
    thinning = SimpleNamespace(run=lambda _at: None)
    records = SimpleNamespace(sessions=sessions, stop_list=SimpleNamespace(is_written=True), thinning=thinning)
    keeper = SimpleNamespace(parts=dict)
    chores = Chores(cast("Any", records), cast("Any", SimpleNamespace()), cast("Any", keeper), FakeClock())
    chores.further.append(free)
    chores.start()
    await freed.wait()
    await chores.stop()
    assert done[:2] == ["sessions", "duty"]
