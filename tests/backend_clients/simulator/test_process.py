"""The simulator as a process: it starts, says where it listens, and ends at once when told."""

from __future__ import annotations

import signal
import socket
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import httpx
import pytest

from backend_clients.simulator.config import RobotConfig, SimulatorConfig
from tests.brokers import free_port

PROGRAM = """
import sys
from pathlib import Path
from backend_clients.simulator.config import SimulatorConfig, RobotConfig
from backend_clients.simulator.process import run_simulator

broker, port, folder = sys.argv[1], int(sys.argv[2]), Path(sys.argv[3])
robots = (RobotConfig("weeder-01", "Weeder 01", "secret"), RobotConfig("weeder-02", "Weeder 02", "secret"))
run_simulator(
    SimulatorConfig(broker, robots, port=port, state_dir=folder), on_ready=lambda port: print(port, flush=True)
)
"""


Start = Callable[..., subprocess.Popen[str]]


@pytest.fixture
def start(tmp_path: Path) -> Iterator[Start]:
    """Start a simulator without a broker; whatever a test left running ends with it."""
    started: list[subprocess.Popen[str]] = []

    def start(port: int = 0) -> subprocess.Popen[str]:
        nobody = f"mqtt://127.0.0.1:{free_port()}"
        command = [sys.executable, "-c", PROGRAM, nobody, str(port), str(tmp_path)]
        started.append(subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True))
        return started[-1]

    yield start
    for process in started:
        process.kill()
        process.communicate()


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
@pytest.mark.slow
def test_it_ends_at_once_even_without_a_broker_and_with_a_request_held(
    start: Start, tmp_path: Path, number: signal.Signals
) -> None:
    process = start()
    assert process.stdout is not None
    assert process.stderr is not None
    port = int(process.stdout.readline())
    base = f"http://127.0.0.1:{port}"
    headers = {"Authorization": "Bearer secret"}
    assert httpx.get(f"{base}/weeder-02/safety", headers=headers, trust_env=False).json()["standstill"] is True
    httpx.post(f"{base}/_faults/weeder-01", json={"fault": "silence", "http": True}, trust_env=False).raise_for_status()
    with socket.create_connection(("127.0.0.1", port)) as held:
        held.sendall(b"GET /weeder-01/safety HTTP/1.1\r\nHost: x\r\nAuthorization: Bearer secret\r\n\r\n")
        process.send_signal(number)
        assert process.wait(20) == 0, "the held request is held much longer"
    assert process.stderr.read() == ""
    assert (tmp_path / "weeder-01" / "progress.json").exists()


@pytest.mark.slow
def test_a_busy_port_is_an_error(start: Start) -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        process = start(taken.getsockname()[1])
        _, said = process.communicate(timeout=20)
    assert process.returncode != 0
    assert "Address already in use" in said


def test_two_robots_with_one_id_are_refused() -> None:
    twin = RobotConfig("weeder-01", "Weeder 01", "secret")
    with pytest.raises(ValueError, match="same id: weeder-01"):
        SimulatorConfig("mqtt://127.0.0.1:1883", (twin, twin))


def test_a_robot_without_a_token_is_refused() -> None:
    with pytest.raises(ValueError, match="token is empty"):
        RobotConfig("weeder-01", "Weeder 01", "")
