"""Ingest: CPU of the receiving process at 4,000 messages a second, and what was lost.

Prints ``ingest_4k_cpu_pct`` and ``ingest_4k_lost``. Ours is the console's coordinator and store; the naive way is paho
with json and a pydantic model per message, each handed to the loop. Both run alone in a process of their own, one
after the other, on the same mosquitto with the same load from a third process.
"""

from __future__ import annotations

import argparse
import asyncio
import json
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from typing import Any, Literal

import paho.mqtt.client as paho
import pydantic
from paho.mqtt.enums import CallbackAPIVersion

from bench.broker import mosquitto
from bench.mqtt_load import robot_id

RATE, ROBOTS, SECONDS = 4000, 200, 10
SETTLE_S = 1.0
CONDITIONS = (
    f"{RATE} msg/s of {ROBOTS} robots for {SECONDS} s, mosquitto on the same machine, acks QoS 1, 1 ping/s a robot"
)


def run() -> Iterator[dict[str, Any]]:
    """Measure both ways and yield the figures."""
    ours, lost, messages = _measure("ours")
    naive, naive_lost, _ = _measure("naive")
    conditions = f"{CONDITIONS}, {messages} messages"
    yield {
        "name": "ingest_4k_cpu_pct",
        "value": round(ours, 1),
        "unit": "% of a core",
        "naive": round(naive, 1),
        "ratio": round(naive / ours, 2),
        "conditions": conditions,
    }
    yield {
        "name": "ingest_4k_lost",
        "value": lost,
        "unit": "newest states and acknowledgements",
        "naive": naive_lost,
        "ratio": None,
        "conditions": conditions,
    }


def _measure(side: str) -> tuple[float, int, int]:
    with mosquitto() as port:
        child = subprocess.Popen(
            [sys.executable, "-m", "bench.ingest", "--side", side, "--port", str(port)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        assert child.stdout is not None
        assert child.stdin is not None
        try:
            child.stdout.readline()  # ready
            size = ["--robots", str(ROBOTS), "--rate", str(RATE), "--seconds", str(SECONDS)]
            command = [sys.executable, "-m", "bench.mqtt_load", "--port", str(port), *size]
            load = subprocess.run(command, capture_output=True, text=True, check=True)
            child.stdin.write("report\n")
            child.stdin.flush()
            heard = json.loads(child.stdout.readline())
        finally:
            child.stdin.close()
            child.wait(10)
    sent = json.loads(load.stdout)
    missed = sum(heard["newest"].get(k) != seq for k, seq in sent["newest"].items() if not k.endswith("/ack"))
    # On a loaded machine the sender may fall behind its rate; the figure is for the full rate all the same.
    return heard["cpu_s"] / sent["sent"] * RATE * 100, missed + sent["acks"] - heard["acks"], sent["sent"]


async def _ours(port: int) -> None:
    from hmi.clock import SystemClock
    from hmi.ingest.coordinator import EdgeCoordinator, mqtt_link
    from hmi.store.fleet import FleetStore
    from tests.hmi.ingest.wire import Entry

    clock = SystemClock()
    store = FleetStore(clock.mono_s)
    store.set_registry([Entry(robot_id(i)) for i in range(ROBOTS)])
    edge = EdgeCoordinator(mqtt_link(f"mqtt://127.0.0.1:{port}", "bench-ours"), store, clock)
    acks = 0

    def count(_ack: object) -> None:
        nonlocal acks
        acks += 1

    edge.listeners.on_ack.append(count)
    await edge.start()
    cpu_s = await _until_asked(lambda: edge.messages)
    newest: dict[str, int] = {}
    for robot in store.robots():
        if robot.telemetry is not None:
            newest[f"{robot.id}/telemetry"] = round(robot.telemetry.pose.x_m / 0.01)
        if robot.link.challenge is not None:
            newest[f"{robot.id}/heartbeat"] = int(robot.link.challenge.removeprefix("challenge-"))
        if robot.safety is not None and robot.safety.stopping_distance_m is not None:
            newest[f"{robot.id}/safety"] = round(robot.safety.stopping_distance_m)
    _report(cpu_s, newest, acks)
    await edge.stop()


def _report(cpu_s: float, newest: dict[str, int], acks: int) -> None:
    print(json.dumps({"cpu_s": cpu_s, "newest": newest, "acks": acks}), flush=True)


async def _until_asked(heard: Callable[[], int]) -> float:
    """Return the CPU time between ``ready`` and the moment when, after being asked, nothing more comes."""
    await asyncio.sleep(1.5)  # connected and subscribed
    begun_s = time.process_time()
    print("ready", flush=True)
    await asyncio.to_thread(sys.stdin.readline)
    before = -1
    while before != heard():  # a starved process is behind, not deaf
        before = heard()
        await asyncio.sleep(SETTLE_S)
    return time.process_time() - begun_s


class _NaiveHeader(pydantic.BaseModel):
    v: int
    robot: str
    boot: str
    seq: int
    mono_ms: int
    wall_ms: int


class _NaiveGnss(pydantic.BaseModel):
    fix: Literal["none", "single", "float", "fixed"]
    accuracy_m: float
    satellites: int
    correction_age_s: float | None = None


class _NaiveBattery(pydantic.BaseModel):
    soc: float = pydantic.Field(ge=0, le=1)
    remaining_s: float | None = None
    charging: bool = False


class _NaiveTool(pydantic.BaseModel):
    state: Literal["off", "armed", "on", "fault"]
    interlock_ok: bool = True
    rate_per_min: float | None = None
    temperature_c: float | None = None


class _NaiveTelemetry(_NaiveHeader):
    lat_deg: float = pydantic.Field(ge=-90, le=90)
    lon_deg: float = pydantic.Field(ge=-180, le=180)
    x_m: float
    y_m: float
    theta_rad: float
    speed_mps: float
    yaw_rate_radps: float = 0.0
    gnss: _NaiveGnss | None = None
    battery: _NaiveBattery | None = None
    tool: _NaiveTool | None = None
    cross_track_m: float | None = None


class _NaiveHeartbeat(_NaiveHeader):
    challenge: str


class _NaiveSafety(_NaiveHeader):
    hardware_stop: bool
    latched: bool
    standstill: bool
    speed_mps: float
    tool_off: bool


class _NaiveAck(_NaiveHeader):
    kind: str
    ref: str
    outcome: str


_NAIVE: dict[str, type[_NaiveHeader]] = {
    "telemetry": _NaiveTelemetry,
    "heartbeat": _NaiveHeartbeat,
    "safety": _NaiveSafety,
    "ack": _NaiveAck,
}


async def _naive(port: int) -> None:
    loop = asyncio.get_running_loop()
    state: dict[str, _NaiveHeader] = {}
    acks = heard = 0

    def keep(topic: str, message: _NaiveHeader) -> None:
        nonlocal acks, heard
        heard += 1
        _, _, robot, kind = topic.split("/")
        acks += kind == "ack"
        state[f"{robot}/{kind}"] = message

    def on_message(_client: Any, _data: Any, message: paho.MQTTMessage) -> None:
        parsed = _NAIVE[message.topic.rpartition("/")[2]].model_validate(json.loads(message.payload))
        loop.call_soon_threadsafe(keep, message.topic, parsed)

    client = paho.Client(CallbackAPIVersion.VERSION2, client_id="bench-naive")
    client.on_message = on_message
    client.connect("127.0.0.1", port)
    client.loop_start()
    client.subscribe("headland/v1/#", 1)
    cpu_s = await _until_asked(lambda: heard)
    _report(cpu_s, {key: m.seq for key, m in state.items()}, acks)
    client.disconnect()
    client.loop_stop()


def main() -> None:
    """Run one receiving side, for a parent that measures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--side", choices=("ours", "naive"), required=True)
    parser.add_argument("--port", type=int, required=True)
    options = parser.parse_args()
    asyncio.run(_ours(options.port) if options.side == "ours" else _naive(options.port))


if __name__ == "__main__":
    main()
