"""What the keeper starts, and when."""

from __future__ import annotations

import errno
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import psutil
import pytest

from hmi.keeper import data_folder
from hmi.keeper import keeper as module
from hmi.keeper import part as part_module
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

    def pid(self, name: str) -> int:
        return int(read_json(self.data / "run" / "keeper.json")["parts"][name]["pid"])

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


def test_a_full_disk_ends_nothing_and_the_view_is_written_when_there_is_room(
    monkeypatch: pytest.MonkeyPatch, watched: Watched, served: set[str]
) -> None:
    watched.waits_for("media", "starting")
    refused = threading.Event()

    def full(_path: Path, _value: object) -> None:
        refused.set()
        raise OSError(errno.ENOSPC, "No space left on device")

    with monkeypatch.context() as disk:
        disk.setattr(module, "write_json", full)
        disk.setattr(module, "overwrite_json", full)
        served.add("media")
        assert refused.wait(10)
        assert watched.thread.is_alive()
    watched.waits_for("cameras", "starting")
    assert watched.state("console") == "ok"


def test_a_part_that_falls_while_the_disk_is_full_is_not_said_to_run(
    monkeypatch: pytest.MonkeyPatch, watched: Watched, served: set[str]
) -> None:
    watched.waits_for("media", "starting")

    def full(*_args: object, **_more: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(data_folder.tempfile, "mkstemp", full)  # no new file, as on a disk without room
    served.add("media")
    watched.waits_for("media", "ok")
    monkeypatch.setattr(part_module, "BACKOFF_S", (1000.0,))
    psutil.Process(watched.pid("media")).kill()
    watched.waits_for("media", "down")


def test_what_has_no_room_in_the_place_of_the_view_leaves_it_whole(tmp_path: Path) -> None:
    view = tmp_path / "keeper.json"
    view.write_text('{"pid": 1}')
    with pytest.raises(OSError, match="No space"):
        data_folder.overwrite_json(view, {"pid": 1, "parts": "x" * data_folder.BLOCK_BYTES})
    assert view.read_text() == '{"pid": 1}'
    data_folder.overwrite_json(view, {})
    assert view.read_text() == "{}"


def test_a_part_that_the_system_has_no_room_for_ends_no_other(
    monkeypatch: pytest.MonkeyPatch, watched: Watched, served: set[str]
) -> None:
    watched.waits_for("media", "starting")
    refused = threading.Event()

    def no_memory(*_args: object, **_more: object) -> None:
        refused.set()
        raise OSError(errno.ENOMEM, "Cannot allocate memory")

    with monkeypatch.context() as system:
        system.setattr(part_module.subprocess, "Popen", no_memory)
        psutil.Process(watched.pid("media")).kill()
        assert refused.wait(10)
        assert watched.thread.is_alive()
        assert psutil.pid_exists(watched.pid("console"))
    served.add("media")
    watched.waits_for("media", "ok")
