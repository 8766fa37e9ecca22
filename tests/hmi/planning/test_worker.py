"""Planning in a process of its own."""

from __future__ import annotations

import asyncio
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import AsyncIterator
from pathlib import Path

import psutil
import pytest

from hmi.domain.mission_plan import PlanRefused
from hmi.planning import worker
from hmi.planning.side_process import SideProcess, SideProcessDied
from hmi.planning.worker import WAITING_LIMIT, PlanningProcess
from tests.hmi.missions.test_document import wish


@pytest.fixture
async def side() -> AsyncIterator[SideProcess]:
    side = SideProcess()
    yield side
    await asyncio.to_thread(side.close)


@pytest.mark.slow
async def test_a_plan_is_made_elsewhere_and_a_refusal_comes_back_whole() -> None:
    planner = PlanningProcess()
    try:
        assert (await planner.plan(wish())).statistics["rows"] > 5
        with pytest.raises(PlanRefused) as refused:
            await planner.plan(wish(width_m=0.0))
        assert (refused.value.code, refused.value.field) == ("width_not_positive", "width_m")
    finally:
        await asyncio.to_thread(planner.close)


@pytest.mark.slow
async def test_a_plan_tells_how_far_it_is(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    monkeypatch.setattr(worker, "PROGRESS_S", 0.02)  # a quick machine plans these 700 rows in half a second
    planner = PlanningProcess()
    heard: list[tuple[float, str]] = []
    try:
        await planner.candidate(wish(width_m=0.05), lambda share, words: heard.append((share, words)))
    finally:
        await asyncio.to_thread(planner.close)
    shares = [share for share, _ in heard]
    assert shares == sorted(set(shares))
    assert 0 < shares[-1] <= 1
    assert any(words.startswith("Row ") for _, words in heard)
    assert await asyncio.to_thread(os.listdir, tmp_path) == []


async def test_a_plan_behind_another_says_that_it_waits() -> None:
    planner = PlanningProcess()
    first = asyncio.create_task(planner.plan(wish()))
    await asyncio.sleep(0)
    heard: list[tuple[float, str]] = []
    second = asyncio.create_task(planner.plan(wish(), lambda share, words: heard.append((share, words))))
    await asyncio.sleep(0)
    try:
        assert heard == [(0.0, "Waiting for the plan before")]
    finally:
        for task in (first, second):
            task.cancel()
        await asyncio.gather(first, second, return_exceptions=True)
        await asyncio.to_thread(planner.close)


async def test_a_plan_that_takes_too_long_is_given_up() -> None:
    planner = PlanningProcess(limit_s=0.01)
    try:
        with pytest.raises(PlanRefused) as refused:
            await planner.plan(wish())
        assert refused.value.code == "too_long"
    finally:
        await asyncio.to_thread(planner.close)


async def test_more_plans_than_can_wait_are_refused_at_once() -> None:
    planner = PlanningProcess()
    waiting = [asyncio.create_task(planner.plan(wish())) for _ in range(WAITING_LIMIT)]
    await asyncio.sleep(0)
    try:
        with pytest.raises(PlanRefused) as refused:
            await planner.plan(wish())
        assert refused.value.code == "busy"
    finally:
        for task in waiting:
            task.cancel()
        await asyncio.gather(*waiting, return_exceptions=True)
        await asyncio.to_thread(planner.close)


async def test_a_process_that_dies_is_told_and_replaced(side: SideProcess) -> None:
    with pytest.raises(SideProcessDied):
        await side.run(os._exit, 3)
    assert await side.run(abs, -2) == 2


async def test_closing_does_not_wait_for_work(side: SideProcess) -> None:
    own = await side.run(os.getpid)
    work = asyncio.create_task(side.run(time.sleep, 60))
    await asyncio.sleep(0)
    await asyncio.wait_for(asyncio.to_thread(side.close), timeout=30)  # the work takes a minute
    await asyncio.gather(work, return_exceptions=True)
    with pytest.raises(ProcessLookupError):
        os.kill(own, 0)


PARENT = """
import asyncio, os, time
from hmi.planning.side_process import SideProcess

async def main():
    side = SideProcess()
    print(await side.run(os.getpid), flush=True)
    await side.run(time.sleep, 60)

if __name__ == "__main__":
    asyncio.run(main())
"""


@pytest.mark.slow
def test_a_parent_that_is_killed_leaves_no_process_behind(tmp_path: Path) -> None:
    script = tmp_path / "parent.py"
    script.write_text(PARENT)
    env = {**os.environ, "PYTHONPATH": str(Path(__file__).parents[3])}
    with subprocess.Popen([sys.executable, str(script)], stdout=subprocess.PIPE, text=True, env=env) as parent:
        assert parent.stdout is not None
        child = psutil.Process(int(parent.stdout.readline()))
        parent.kill()
    _gone, alive = psutil.wait_procs([child], timeout=20)
    assert alive == []
