"""What simulated robots cost: CPU of the simulator's process with a farm of 24, and with 1,000 lean robots.

A stand-in for the console pings every robot once a second, as the console does; without it robots at work would pause.
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import psutil
from paho.mqtt.client import Client
from paho.mqtt.enums import CallbackAPIVersion

from backend_clients.edge import codec
from backend_clients.edge import messages_down as down
from backend_clients.edge.topics import Down, topic
from bench.broker import mosquitto

SETTLE_S, SECONDS = 25.0, 20.0


def run() -> Iterator[dict[str, Any]]:
    """Measure a full fleet, then a lean one."""
    yield from _measure("simulator_fleet_cpu_pct", 24, "24 full robots, 17 at work, telemetry at 10 Hz", [])
    yield from _measure("simulator_lean_cpu_pct", 1000, "1,000 lean robots, all at work, 2 Hz", ["--lean", "1000"])


def _measure(name: str, robots: int, conditions: str, options: list[str]) -> Iterator[dict[str, Any]]:
    with mosquitto() as port, tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "robots.json"
        command = [sys.executable, "-m", "hmi", "simulate", "fleet", "--broker", f"mqtt://127.0.0.1:{port}"]
        process = subprocess.Popen([*command, "--out", str(out), *options], stdout=subprocess.DEVNULL)
        try:
            pct, beats, at_work = _watch(process, port, out)
        finally:
            process.terminate()
            process.wait(5)
    said = f"{conditions}; {at_work} in AUTO; {beats / robots:.1f} heartbeats/s and {pct / robots:.2f} % a robot"
    yield {"name": name, "value": round(pct, 1), "unit": "% of a core", "naive": None, "ratio": None,
           "conditions": said}  # fmt: skip


def _watch(process: subprocess.Popen[bytes], port: int, out: Path) -> tuple[float, float, int]:
    """Return CPU percent, heartbeats a second (fewer than due: the machine was too busy), and robots in AUTO."""
    deadline_s = time.monotonic() + 60
    while not out.exists() or not out.stat().st_size:
        if time.monotonic() > deadline_s or process.poll() is not None:
            raise RuntimeError("the simulator did not start")
        time.sleep(0.1)
    ids = [row["id"] for row in json.loads(out.read_text("utf-8"))]
    heard, modes = [0], dict[str, str]()
    client = Client(CallbackAPIVersion.VERSION2)

    def note(_client: Client, _user: Any, message: Any) -> None:
        heard[0] += 1
        if message.topic.endswith("/state"):
            modes[message.topic.split("/")[2]] = json.loads(message.payload)["mode"]

    client.on_message = note
    client.connect("127.0.0.1", port)
    client.subscribe("headland/v1/+/heartbeat")
    client.loop_start()
    ended = threading.Event()
    pinging = threading.Thread(target=_ping, args=(client, ids, ended))
    pinging.start()
    try:
        time.sleep(SETTLE_S)
        simulator = psutil.Process(process.pid)
        before, count, begun_s = sum(simulator.cpu_times()[:2]), heard[0], time.monotonic()
        time.sleep(SECONDS)
        took_s = time.monotonic() - begun_s
        pct = 100 * (sum(simulator.cpu_times()[:2]) - before) / took_s
        beats = (heard[0] - count) / took_s
        client.subscribe("headland/v1/+/state")
        time.sleep(3.0)
        return float(pct), beats, sum(mode == "auto" for mode in modes.values())
    finally:
        ended.set()
        pinging.join()
        client.loop_stop()


def _ping(client: Client, ids: list[str], ended: threading.Event) -> None:
    while not ended.wait(1.0):
        for robot_id in ids:
            client.publish(topic(robot_id, Down.PING), codec.encode(down.Ping(robot=robot_id, nonce="console-b")))
