"""Starting, running and ending an installation as a person does it."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
from pathlib import Path

import psutil
import pytest

from tests.e2e.installation import END_LIMIT_S, ROOT, Installation
from tests.e2e.person import wait_for

pytestmark = pytest.mark.browser


def headland(*arguments: str, **env: str) -> subprocess.CompletedProcess[str]:
    """Run one command of ``headland`` to its end."""
    clean = {k: v for k, v in os.environ.items() if not k.startswith("HEADLAND_")}
    return subprocess.run(
        [sys.executable, "-m", "hmi", *arguments],
        cwd=ROOT,
        env={**clean, **env},
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )


def left_of(data: Path) -> list[psutil.Process]:
    """Return processes of the installation on ``data``: without any, nobody of it holds a port either.

    The port itself may be another test's by now.
    """

    def is_ours(process: psutil.Process) -> bool:
        try:
            return process.environ().get("HEADLAND_DATA") == str(data)
        except (psutil.AccessDenied, psutil.NoSuchProcess):
            return False

    return [process for process in psutil.process_iter() if is_ours(process)]


def test_ctrl_c_ends_everything_and_leaves_no_process_and_no_port(tmp_path: Path) -> None:
    running = Installation.start(tmp_path / "data", has_media=True, has_cameras=True)
    wait_for(lambda: running.keeper()["cameras"]["pid"], within_s=30, what="what nobody waits for starts")
    pids = [part["pid"] for part in running.keeper().values()]
    assert len(pids) == 6
    assert {one.pid for one in left_of(tmp_path / "data")} >= {*pids, running.process.pid}
    took_s = running.end()
    assert running.process.returncode == 0
    assert took_s <= 2 * END_LIMIT_S  # two stories share the machine; `make bench` has the figure
    assert not any(psutil.pid_exists(pid) for pid in pids)
    assert left_of(tmp_path / "data") == []


@pytest.mark.long
def test_a_killed_console_comes_back_and_health_remembers(calm: Installation) -> None:
    before = calm.keeper()["console"]
    os.kill(before["pid"], signal.SIGKILL)
    restarts = before["restarts"] + 1  # another test of this installation may have killed it too
    wait_for(lambda: calm.keeper()["console"]["restarts"] == restarts, within_s=5, what="the keeper starts it again")
    wait_for(lambda: calm.keeper()["console"]["state"] == "ok", within_s=40, what="it serves again")
    console = calm.health()["parts"]["console"]
    assert console["restarts"] == restarts
    assert console["last_down"] is not None


def test_a_busy_port_is_one_sentence_and_an_exit_code(tmp_path: Path) -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = str(taken.getsockname()[1])
        ended = headland("demo", HEADLAND_PORT=port, HEADLAND_DATA=str(tmp_path / "data"))
    assert ended.returncode != 0
    assert f"Port {port} on 127.0.0.1 is in use by another program" in ended.stderr
    assert "Traceback" not in ended.stderr


def test_serving_with_the_default_secret_is_refused(tmp_path: Path) -> None:
    ended = headland("serve", HEADLAND_DATA=str(tmp_path / "data"))
    assert ended.returncode != 0
    assert "the secret is the default one" in ended.stderr
    assert "Traceback" not in ended.stderr
