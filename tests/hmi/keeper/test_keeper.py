"""What the keeper starts, and when."""

from __future__ import annotations

import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from hmi.keeper import keeper as module
from hmi.keeper.data_folder import read_json
from hmi.keeper.keeper import Keeper
from hmi.keeper.part import PartSpec

FOREVER = (sys.executable, "-c", "import time; time.sleep(60)")


class Watched:
    """A keeper in a thread, and what its parts are said to be."""

    def __init__(self, keeper: Keeper, data: Path) -> None:
        self.keeper, self.data = keeper, data
        self.thread = threading.Thread(target=keeper.run, args=(lambda: None,))

    def state(self, name: str) -> str:
        told = read_json(self.data / "run" / "keeper.json") or {}
        return str(told.get("parts", {}).get(name, {}).get("state", ""))

    def waits_for(self, name: str, state: str) -> None:
        until_s = time.monotonic() + 20
        while self.state(name) != state:
            assert time.monotonic() < until_s, f"{name} is {self.state(name)}"
            threading.Event().wait(0.02)


@pytest.fixture
def no_signals(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module.signal, "signal", lambda *_args: None)  # only the main thread may set them
    monkeypatch.setattr(module, "LATER_S", 0.0)


@pytest.fixture
def served() -> set[str]:
    """Names of the parts that serve."""
    return {"console"}


@pytest.fixture
def watched(no_signals: None, served: set[str], tmp_path: Path) -> Iterator[Watched]:
    def spec(name: str) -> PartSpec:
        return PartSpec(name, FOREVER, is_ready=lambda: name in served, dies_with_keeper=False)

    for folder in ("logs", "run"):
        (tmp_path / folder).mkdir()
    one = Watched(Keeper([spec("console")], tmp_path, [spec("media"), spec("cameras")]), tmp_path)
    one.thread.start()
    yield one
    one.keeper.end()
    one.thread.join(10)


def test_parts_nobody_waits_for_start_one_after_the_other(watched: Watched, served: set[str]) -> None:
    watched.waits_for("media", "starting")
    assert watched.state("cameras") == "stopped"
    served.add("media")
    watched.waits_for("cameras", "starting")
    served.add("cameras")
    watched.waits_for("cameras", "ok")


def test_one_that_does_not_come_up_holds_up_the_next_no_longer_than_its_time(
    monkeypatch: pytest.MonkeyPatch, watched: Watched
) -> None:
    watched.waits_for("media", "starting")
    monkeypatch.setattr(module, "LATER_EACH_S", 0.1)
    watched.waits_for("cameras", "starting")
    assert watched.state("media") == "starting"
