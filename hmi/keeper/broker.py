"""The demo's MQTT broker: mosquitto where it is installed, amqtt in its own process where it is not."""

from __future__ import annotations

import os
import shutil
import socket
import sys
from pathlib import Path

from hmi.keeper.part import PartSpec

_PLACES = os.pathsep.join((os.environ.get("PATH", os.defpath), "/usr/sbin", "/usr/local/sbin", "/opt/homebrew/sbin"))


def find_mosquitto() -> str | None:
    """Return the path of mosquitto; Debian puts it where an ordinary user's PATH does not look."""
    return shutil.which("mosquitto", path=_PLACES)


def demo_broker(data: Path, port: int) -> PartSpec:
    """Return a broker on loopback for the demo; it keeps nothing on disk."""
    program = find_mosquitto()
    if program is None:
        argv: tuple[str, ...] = (
            sys.executable, "-m", "backend_clients.simulator.broker", "--port", str(port), "--name", "headland",
        )  # fmt: skip
    else:
        config = data / "run" / "mosquitto.conf"
        config.write_text(
            f"listener {port} 127.0.0.1\nallow_anonymous true\npersistence false\n"
            "max_queued_messages 2000\nset_tcp_nodelay true\nlog_type error\nlog_type warning\n",
            encoding="utf-8",
        )
        argv = (program, "-c", str(config))
    return PartSpec(
        "broker",
        argv,
        is_ready=lambda: answers("127.0.0.1", port),
        url=f"mqtt://127.0.0.1:{port}",
        dies_with_keeper=True,
    )


def answers(host: str, port: int) -> bool:
    """Say whether something listens on ``host:port``."""
    try:
        with socket.create_connection((host, port), timeout=0.3):
            return True
    except OSError:
        return False
