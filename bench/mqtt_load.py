"""Robots at a steady rate or in bursts, cheap enough that the sender is not what is measured.

``python -m bench.mqtt_load --port P --robots 200 --rate 4000 --seconds 10`` publishes and then prints one JSON line:
how many messages, and the newest sequence of every robot and kind. With ``--burst 10000 --every 2`` so many come at
once every 2 s, as after a broken link; ``--rate`` says nothing then. Packets are written to the socket as MQTT 3.1.1
has them; per robot 10 telemetry, 5 heartbeats, 4 safety states and 1 acknowledgement (QoS 1) of 20 messages.
"""

from __future__ import annotations

import argparse
import json
import socket
import struct
import threading
import time
from typing import Any

import msgspec

from backend_clients.edge import messages_up as up

BEAT_S = 0.01
BURST = 200  # a sender that fell behind must not spend its time on catching up at once
PATTERN = ("telemetry", "heartbeat", "telemetry", "safety") * 5
ACK_AT = 19  # the last safety state of the pattern is an acknowledgement


def robot_id(number: int) -> str:
    """Return the id of a simulated robot."""
    return f"load-{number:04d}"


def body(kind: str, number: int, seq: int, mono_ms: int) -> bytes:
    """Return an honest message of one kind."""
    head: dict[str, Any] = {
        "robot": robot_id(number),
        "boot": f"boot-{number:04d}-load",
        "seq": seq,
        "mono_ms": mono_ms,
        "wall_ms": 1_777_000_000_000,
    }
    return msgspec.json.encode(_MAKERS[kind](head, seq))


_MAKERS: dict[str, Any] = {
    "telemetry": lambda head, seq: up.Telemetry(
        **head,
        lat_deg=52.0 + seq * 1e-7,
        lon_deg=5.0,
        x_m=seq * 0.01,
        y_m=0.0,
        theta_rad=0.1,
        speed_mps=0.42,
        gnss=up.Gnss(fix="fixed", accuracy_m=0.014, satellites=27, correction_age_s=0.8),
        battery=up.Battery(soc=0.68, remaining_s=18600.0),
        tool=up.ToolState(state="on", rate_per_min=212.0, temperature_c=41.0),
        cross_track_m=0.009,
    ),
    "heartbeat": lambda head, seq: up.Heartbeat(**head, challenge=f"challenge-{seq}"),
    "safety": lambda head, seq: up.Safety(
        **head,
        hardware_stop=False,
        latched=False,
        standstill=False,
        speed_mps=0.42,
        tool_off=False,
        stopping_distance_m=float(seq),  # so that the receiver can tell which one it has
    ),
    "ack": lambda head, seq: up.Ack(**head, kind="command", ref=f"command-{seq}", outcome="accepted"),
}


def packet(topic: str, payload: bytes, packet_id: int) -> bytes:
    """Return an MQTT 3.1.1 PUBLISH; QoS 1 if ``packet_id`` is not 0."""
    name = topic.encode()
    variable = struct.pack("!H", len(name)) + name + (struct.pack("!H", packet_id) if packet_id else b"")
    length, size = len(variable) + len(payload), b""
    while True:
        length, digit = divmod(length, 128)
        size += bytes([digit | (0x80 if length else 0)])
        if not length:
            return bytes([0x32 if packet_id else 0x30]) + size + variable + payload


def connect(port: int) -> socket.socket:
    """Open a connection to the broker."""
    sock = socket.create_connection(("127.0.0.1", port))
    name = b"bench-load"
    variable = b"\x00\x04MQTT\x04\x02\x00\x00" + struct.pack("!H", len(name)) + name
    sock.sendall(bytes([0x10, len(variable)]) + variable)
    if sock.recv(4)[3] != 0:
        raise RuntimeError("the broker refused the load")
    threading.Thread(target=_discard, args=(sock,), daemon=True).start()  # PUBACKs
    return sock


def _discard(sock: socket.socket) -> None:
    try:
        while sock.recv(65536):
            pass
    except OSError:
        return


class Load:
    """Makes one message after the other and counts them."""

    def __init__(self, robots: int) -> None:
        self.sent, self.acks, self.newest = 0, 0, dict[str, int]()
        self._robots = robots
        self._started_s = time.monotonic()

    def passed_s(self) -> float:
        """Return how long ago the first message could have been made."""
        return time.monotonic() - self._started_s

    def packets(self, count: int) -> bytes:
        """Return the next ``count`` messages."""
        return b"".join(self._next() for _ in range(count))

    def told(self) -> dict[str, Any]:
        """Return what was sent."""
        return {"sent": self.sent, "acks": self.acks, "newest": self.newest}

    def _next(self) -> bytes:
        number, turn = self.sent % self._robots, self.sent // self._robots
        kind = "ack" if turn % len(PATTERN) == ACK_AT else PATTERN[turn % len(PATTERN)]
        self.sent += 1
        self.acks += kind == "ack"
        self.newest[f"{robot_id(number)}/{kind}"] = self.sent
        payload = body(kind, number, self.sent, round(self.passed_s() * 1000) + 1)
        packet_id = self.sent % 65535 + 1 if kind == "ack" else 0
        return packet(f"headland/v1/{robot_id(number)}/{kind}", payload, packet_id)


def publish(port: int, robots: int, rate: float, seconds: float) -> dict[str, Any]:
    """Publish at ``rate`` messages a second and return what was sent."""
    sock = connect(port)
    load = Load(robots)
    while (passed_s := load.passed_s()) < seconds:
        if due := min(BURST, int(passed_s * rate) - load.sent):
            sock.sendall(load.packets(due))
        time.sleep(BEAT_S)
    return _closed(sock, load)


def publish_bursts(port: int, robots: int, size: int, every_s: float, seconds: float) -> dict[str, Any]:
    """Publish ``size`` messages at once every ``every_s`` and return what was sent."""
    sock = connect(port)
    load = Load(robots)
    while load.passed_s() < seconds:
        begun_s = load.passed_s()
        sock.sendall(load.packets(size))
        time.sleep(max(0.0, begun_s + every_s - load.passed_s()))
    return _closed(sock, load)


def _closed(sock: socket.socket, load: Load) -> dict[str, Any]:
    time.sleep(0.5)
    sock.close()
    return load.told()


def main() -> None:
    """Parse the arguments and publish."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--port", type=int, required=True)
    parser.add_argument("--robots", type=int, default=200)
    parser.add_argument("--rate", type=float, default=4000)
    parser.add_argument("--seconds", type=float, default=10)
    parser.add_argument("--burst", type=int, default=0)
    parser.add_argument("--every", type=float, default=2)
    options = parser.parse_args()
    if options.burst:
        told = publish_bursts(options.port, options.robots, options.burst, options.every, options.seconds)
    else:
        told = publish(options.port, options.robots, options.rate, options.seconds)
    print(json.dumps(told), flush=True)


if __name__ == "__main__":
    main()
