"""The keeper restarts what falls and ends what runs."""

from __future__ import annotations

import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path

import psutil
import pytest

from hmi.keeper.data_folder import keep_secret, read_json, require_writable
from hmi.keeper.errors import StartError
from hmi.keeper.keeper import Keeper
from hmi.keeper.part import Part, PartSpec
from hmi.keeper.ports import free_port, require_free

SLEEPER = (sys.executable, "-c", "import time; time.sleep(60)  # hmi.cli")
FALLER = (sys.executable, "-c", "print('the reason'); raise SystemExit(1)")


def eventually(condition: Callable[[], bool], limit_s: float = 10.0) -> bool:
    """Poll ``condition`` until it holds; processes of the system offer nothing to wait on."""
    deadline_s = time.monotonic() + limit_s
    while time.monotonic() < deadline_s:
        if condition():
            return True
        threading.Event().wait(0.02)
    return False


def start_sleeper() -> psutil.Popen:
    """Start a process of ours; the system shows its words a moment after it runs."""
    process = psutil.Popen(SLEEPER)
    assert eventually(lambda: "hmi.cli" in " ".join(process.cmdline()))
    return process


@pytest.fixture
def data(tmp_path: Path) -> Path:
    return require_writable(tmp_path / "data")


def test_a_part_that_is_killed_is_started_again_and_its_absence_is_remembered(data: Path) -> None:
    part = Part(PartSpec("sleeper", SLEEPER), data / "logs")
    part.start()
    try:
        assert eventually(lambda: part.watch() and part.state == "ok")
        first = part.pid
        assert first is not None
        psutil.Process(first).kill()
        assert eventually(lambda: (part.watch(), part.pid not in (None, first) and part.state == "ok")[1])
        assert part.restarts == 1
        assert part.describe()["last_down"] is not None
    finally:
        part.terminate()
        part.wait(time.monotonic() + 5)
    assert part.pid is None


@pytest.mark.slow
def test_a_part_that_keeps_falling_waits_longer_each_time(data: Path) -> None:
    part = Part(PartSpec("faller", FALLER), data / "logs")
    part.start()
    assert eventually(lambda: (part.watch(), part.restarts >= 2)[1])
    assert part.state in ("down", "starting")
    assert "the reason" in part.log_tail()
    part.terminate()
    part.wait(time.monotonic() + 5)


@pytest.mark.slow
def test_keeper_says_why_a_part_does_not_start(data: Path) -> None:
    keeper = Keeper([PartSpec("faller", FALLER, is_ready=lambda: False)], data)
    with pytest.raises(StartError, match="the reason"):
        keeper.run(lambda: None)
    assert not (data / "run" / "keeper.json").exists()


def test_keeper_ends_every_process_when_told(data: Path) -> None:
    keeper = Keeper([PartSpec("one", SLEEPER), PartSpec("two", SLEEPER, after=("one",))], data)
    pids: list[int] = []

    def ready() -> None:
        parts = read_json(data / "run" / "keeper.json")["parts"]
        pids.extend(part["pid"] for part in parts.values())
        keeper.end()

    keeper.run(ready)
    assert len(pids) == 2
    assert not any(psutil.pid_exists(pid) for pid in pids)


def test_a_part_starts_only_when_those_before_it_serve(data: Path) -> None:
    serving: list[str] = []
    seen: list[tuple[object, ...]] = []

    def is_first_ready() -> bool:
        parts = read_json(data / "run" / "keeper.json")["parts"]
        seen.append((parts["first"]["pid"] is None, parts["second"]["pid"] is None, parts["beside"]["pid"] is None))
        serving.append("first")
        return len(serving) > 3

    first = PartSpec("first", SLEEPER, is_ready=is_first_ready)
    keeper = Keeper([PartSpec("second", SLEEPER, after=("first",)), first, PartSpec("beside", SLEEPER)], data)
    keeper.run(keeper.end)
    assert seen[:3] == [(False, True, False)] * 3


def test_a_second_keeper_of_the_same_data_folder_is_refused(data: Path) -> None:
    refusals: list[str] = []
    keeper = Keeper([PartSpec("one", SLEEPER)], data)
    earlier = start_sleeper()
    try:
        (data / "run" / "keeper.json").write_text(f'{{"pid": {earlier.pid}, "parts": {{}}}}')
        with pytest.raises(StartError) as refusal:
            keeper.run(lambda: None)
        refusals.append(str(refusal.value))
    finally:
        earlier.kill()
        earlier.wait()
    assert "already runs" in refusals[0]


def test_left_overs_of_a_killed_keeper_are_ended_first(data: Path) -> None:
    orphan = start_sleeper()
    record = f'{{"pid": null, "parts": {{"one": {{"pid": {orphan.pid}}}}}}}'
    (data / "run" / "keeper.json").write_text(record)
    keeper = Keeper([PartSpec("one", SLEEPER)], data)
    keeper.run(keeper.end)
    assert not orphan.is_running()


def test_a_busy_port_is_one_clear_sentence() -> None:
    import socket

    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        with pytest.raises(StartError, match=f"Port {port} on 127.0.0.1 is in use .* HEADLAND_PORT"):
            require_free("127.0.0.1", port, "HEADLAND_PORT")


def test_a_free_port_is_free() -> None:
    require_free("127.0.0.1", free_port(), "HEADLAND_PORT")


def test_a_data_folder_that_is_a_file_is_refused(tmp_path: Path) -> None:
    (tmp_path / "data").write_text("")
    with pytest.raises(StartError, match="HEADLAND_DATA"):
        require_writable(tmp_path / "data")


def test_a_secret_is_made_once_and_read_by_its_owner_only(tmp_path: Path) -> None:
    first = keep_secret(tmp_path / "secret")
    assert len(first) >= 32
    assert keep_secret(tmp_path / "secret") == first
    assert (tmp_path / "secret").stat().st_mode & 0o077 == 0
