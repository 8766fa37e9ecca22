"""Whom STOP ALL means and what the heartbeat tells of robots, on a clock that only the test moves."""

from __future__ import annotations

import errno
import json
from pathlib import Path

import pytest

from hmi.clock import FakeClock
from hmi.domain.stop import SafetyReport
from hmi.domain.stop_book import MAX_STRANGERS
from hmi.domain.stop_token import StopToken
from hmi.stop_gateway.dispatcher import StopDispatcher
from hmi.stop_gateway.http_path import HttpEvents, HttpPath
from hmi.stop_gateway.registry import Registry, RobotEntry

MARTHA = StopToken("tablet-3", "Tablet 3", "martha", "Martha Keller", "farm")


class Farm:
    """A gateway without sockets: weeder-01 is registered, new-robot is heard and not accepted."""

    def __init__(self, folder: Path) -> None:
        (folder / "robots.json").write_text(json.dumps([{"id": "weeder-01", "name": "Weeder 01"}]), "utf-8")
        self.clock = FakeClock()
        self.gateway = StopDispatcher(self.clock, Registry(folder), lambda _attempts: None, "mqtt://127.0.0.1:1")

    def hear(self, robot_id: str) -> None:
        self.gateway.watch.heard(robot_id, self.clock.mono_s())

    def report(self, robot_id: str, *, live: str = "") -> None:
        now_s = self.clock.mono_s()
        report = SafetyReport("boot-1", now_s, bool(live), True, True, False, 0.0, frozenset({live} if live else ()))
        self.gateway.watch.reported(robot_id, report, now_s)
        self.gateway.book.reported(robot_id, report, now_s)

    def press(self, stop_id: str) -> set[str]:
        return {step["robot"] for step in self.gateway.press(stop_id, "all", MARTHA)}


@pytest.fixture
async def farm(tmp_path: Path) -> Farm:
    made = Farm(tmp_path)
    await made.gateway.refresh()
    return made


async def test_stop_all_goes_to_every_robot_that_the_heartbeat_lists(farm: Farm) -> None:
    for robot_id in ("weeder-01", "new-robot"):
        farm.hear(robot_id)
    assert farm.press("stop-all-1") == {"weeder-01", "new-robot"}
    farm.report("new-robot", live="stop-all-1")
    farm.clock.advance(3600)  # it stood and was switched off; nobody could reset it
    farm.hear("weeder-01")
    assert farm.press("stop-all-2") == set(farm.gateway.heartbeat()) == {"weeder-01", "new-robot"}
    assert farm.gateway.heartbeat()["new-robot"]["name"] == "new-robot (not registered)"


async def test_stop_all_goes_to_a_robot_that_left_the_list_after_the_last_heartbeat(farm: Farm) -> None:
    farm.hear("new-robot")
    farm.clock.advance(59.9)
    assert "new-robot" in farm.gateway.heartbeat()
    farm.clock.advance(1.0)
    assert "new-robot" not in farm.gateway.heartbeat()
    assert farm.press("stop-all-1") == {"weeder-01", "new-robot"}


async def test_who_was_dropped_from_the_list_takes_no_listed_robots_place(farm: Farm) -> None:
    farm.hear("gone-01")
    farm.clock.advance(61.0)
    listed = {f"new-{number}" for number in range(MAX_STRANGERS)}
    for robot_id in listed:
        farm.hear(robot_id)
    assert farm.press("stop-all-1") >= listed


async def test_before_the_first_list_stop_all_goes_to_presses_of_before_a_restart_too(tmp_path: Path) -> None:
    before, after = Farm(tmp_path), Farm(tmp_path)
    await before.gateway.refresh()
    before.press("stop-all-1")
    after.gateway.restore(before.gateway.book.attempts())
    assert after.press("stop-all-2") == set(after.gateway.heartbeat()) == {"weeder-01"}


async def test_the_heartbeat_tells_how_old_the_safety_report_is_beside_the_newest_sign_of_life(farm: Farm) -> None:
    farm.hear("weeder-01")
    assert farm.gateway.heartbeat()["weeder-01"]["safety_ms"] is None
    farm.report("weeder-01", live="stop-1")
    farm.clock.advance(12)
    farm.hear("weeder-01")
    line = farm.gateway.heartbeat()["weeder-01"]
    assert (line["heard_ms"], line["safety_ms"], line["standstill"]) == (0, 12_000, True)


async def test_a_report_that_does_not_count_for_the_presses_is_no_fresh_proof(farm: Farm) -> None:
    def report(boot: str, *, standstill: bool) -> None:
        now_s = farm.clock.mono_s()
        said = SafetyReport(boot, now_s, True, standstill, True, False, 0.0 if standstill else 0.5, frozenset({"one"}))
        farm.gateway.watch.reported("weeder-01", said, now_s)
        farm.gateway.book.reported("weeder-01", said, now_s)

    farm.hear("weeder-01")
    farm.gateway.press("one", ["weeder-01"], MARTHA)
    for boot in ("boot-1", "boot-2"):
        report(boot, standstill=True)
    states = set()
    for _ in range(40):
        farm.clock.advance(0.1)
        report("boot-1", standstill=False)  # it says so itself: it moves
        (step,) = farm.gateway.steps("one")
        line = farm.gateway.heartbeat()["weeder-01"]
        states.add(step["state"])
        assert step["state"] == "not-confirmed" or (line["standstill"] and line["safety_ms"] > 0)
    assert states == {"standstill", "not-confirmed"}


async def test_an_address_or_token_that_cannot_be_used_keeps_http_from_no_other_robot() -> None:
    every = [
        RobotEntry("weeder-01", http_url="http://10.0.0.7:9000", token="gehölz"),
        RobotEntry("weeder-02", http_url="http://10.0.0.7:x", token="t"),
        RobotEntry("weeder-03", http_url="http://10.0.0.7:9000", token="t"),
    ]
    path = HttpPath(HttpEvents(lambda *_told: None, lambda *_told: None))
    path.follow({one.id: one for one in every})
    assert [one.id for one in every if path.has(one.id)] == ["weeder-03"]
    await path.close()


def test_a_list_that_could_not_be_read_is_read_at_the_next_look(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "robots.json").write_text('[{"id": "weeder-01"}]', "utf-8")
    (tmp_path / "revoked.json").write_text('["tablet-9"]', "utf-8")
    registry = Registry(tmp_path)

    def too_many(_self: Path) -> bytes:
        raise OSError(errno.EMFILE, "Too many open files")

    with monkeypatch.context() as system:
        system.setattr(Path, "read_bytes", too_many)
        assert not registry.refresh()
    assert registry.refresh()
    assert list(registry.robots) == ["weeder-01"]
    assert registry.is_revoked("tablet-9")
    assert not registry.refresh()
