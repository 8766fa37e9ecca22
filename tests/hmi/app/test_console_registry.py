"""A robot that is taken out of the registry takes with it what was put aside for it, and who answered for it."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

from hmi.app.console import Console
from hmi.clock import FakeClock
from hmi.store.fleet import FleetStore
from tests.hmi.ingest.wire import Entry


async def test_alarms_duties_and_queues_hear_of_a_robot_in_the_moment_in_which_it_is_taken_out() -> None:
    fleet = FleetStore(FakeClock().mono_s)
    fleet.set_registry([Entry("weeder-01"), Entry("weeder-02")])
    removed: list[str] = []
    freed: list[set[str]] = []
    ended: list[set[str]] = []
    work: list[Any] = []

    async def let_go(*, robots: set[str]) -> None:
        freed.append(robots)

    async def unqueue(robots: set[str]) -> None:
        ended.append(robots)

    console = SimpleNamespace(
        edge=SimpleNamespace(fleet=fleet),
        records=SimpleNamespace(robots=SimpleNamespace(all=lambda: [Entry("weeder-01"), Entry("weeder-03")])),
        alarms=SimpleNamespace(robot_removed=removed.append),
        fleet=SimpleNamespace(duty=SimpleNamespace(let_go=let_go)),
        queue=SimpleNamespace(book=SimpleNamespace(robots_removed=unqueue)),
        _soon=work.append,
    )
    for _ in range(2):  # the second time nothing has changed
        Console.sync_registry(cast("Any", console))
    for one in work:
        await one
    assert (removed, freed, ended) == (["weeder-02"], [{"weeder-02"}], [{"weeder-02"}])
