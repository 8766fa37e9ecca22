"""Real MQTT brokers for tests, each in a process of its own on a free loopback port."""

from __future__ import annotations

import contextlib
import shutil
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import IO

START_S = 15.0
MOSQUITTO = shutil.which("mosquitto") or shutil.which("mosquitto", path="/usr/sbin:/usr/local/sbin")


def free_port() -> int:
    """Return a loopback port nobody listens on now."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


@contextlib.contextmanager
def start_mosquitto(folder: Path, port: int | None = None) -> Iterator[str]:
    """Run mosquitto; the value is its ``mqtt://`` address."""
    assert MOSQUITTO, "mosquitto is not installed"
    port = port or free_port()
    config = folder / f"mosquitto-{port}.conf"
    config.write_text(f"listener {port} 127.0.0.1\nallow_anonymous true\npersistence false\nset_tcp_nodelay true\n")
    with _process([MOSQUITTO, "-c", str(config)], port) as url:
        yield url


@contextlib.contextmanager
def start_amqtt(port: int | None = None) -> Iterator[str]:
    """Run the project's own small broker; the value is its ``mqtt://`` address."""
    port = port or free_port()
    with _process([sys.executable, "-m", "backend_clients.simulator.broker", "--port", str(port)], port) as url:
        yield url


@contextlib.contextmanager
def _process(command: list[str], port: int) -> Iterator[str]:
    # a file, since a pipe nobody reads would block a talkative broker
    with tempfile.TemporaryFile() as said:
        process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=said)
        try:
            _wait_for(port, process, said)
            yield f"mqtt://127.0.0.1:{port}"
        finally:
            process.terminate()
            try:
                process.wait(3)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()


def _wait_for(port: int, process: subprocess.Popen[bytes], said: IO[bytes]) -> None:
    until = time.monotonic() + START_S
    while time.monotonic() < until:
        if process.poll() is not None:
            said.seek(0)
            text = said.read().decode(errors="replace")
            raise AssertionError(f"broker ended with {process.returncode}: {text[-2000:]}")
        with contextlib.suppress(OSError), socket.create_connection(("127.0.0.1", port), 0.2):
            return
        time.sleep(0.02)
    raise AssertionError(f"no broker on port {port} after {START_S:g} s")
