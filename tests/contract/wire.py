"""Both ends of the wire for contract tests: a simulator on a thread, and a listener that waits for messages."""

from __future__ import annotations

import asyncio
import contextlib
import threading
import time
import uuid
from collections.abc import Callable, Iterator
from typing import Any, TypeVar

import httpx

from backend_clients.edge import codec
from backend_clients.edge import messages_down as down
from backend_clients.edge import messages_up as up
from backend_clients.edge.mqtt import LinkState, MqttLink
from backend_clients.edge.topics import Down, Up, parse, topic
from backend_clients.simulator.config import RobotConfig, SimulatorConfig
from backend_clients.simulator.process import Simulator

ROBOT, TOKEN = "weeder-01", "secret-1"
WAIT_S = 10.0
T = TypeVar("T", bound=up.Header)


class Listener:
    """Hears everything a robot says and sends it orders; ``wait`` blocks until it hears what is wanted."""

    def __init__(self, url: str, robot: str = ROBOT) -> None:
        self.robot = robot
        self.heard: list[tuple[up.Header, bool]] = []
        self.faults: list[Exception] = []
        self._news = threading.Condition()
        self._is_up = threading.Event()
        self.link = MqttLink(
            url,
            f"listener-{uuid.uuid4().hex[:8]}",
            subscriptions=[(topic(robot, kind), 1) for kind in Up],
            on_message=self._on_message,
            on_link=lambda state, _text: self._is_up.set() if state is LinkState.UP else self._is_up.clear(),
            on_fault=self.faults.append,
        )
        self.seq = 0

    def __enter__(self) -> Listener:
        self.link.start()
        assert self._is_up.wait(WAIT_S), "no connection to the broker"
        return self

    def __exit__(self, *_: object) -> None:
        self.link.stop()
        assert self.faults == [], self.faults

    def _on_message(self, name: str, payload: bytes, is_retained: bool) -> None:
        # amqtt 0.12 hands a new client what is retained for other clients' subscriptions too
        if not isinstance(parse(name).kind, Up):
            return
        message = codec.decode(name, payload)[1]
        assert isinstance(message, up.Header)
        with self._news:
            self.heard.append((message, is_retained))
            self._news.notify_all()

    def mark(self) -> int:
        """Return a place in what was heard, for ``wait(since=...)``."""
        with self._news:
            return len(self.heard)

    def wait(
        self, kind: type[T], wanted: Callable[[T], bool] = lambda _: True, *, since: int = 0, timeout_s: float = WAIT_S
    ) -> T:
        """Return the first message of ``kind`` that is wanted; fails after ``timeout_s``."""
        found: list[T] = []

        def look() -> bool:
            found.extend(m for m, _ in self.heard[since:] if isinstance(m, kind) and wanted(m))
            return bool(found)

        with self._news:
            assert self._news.wait_for(look, timeout_s), f"no such {kind.__name__} in {timeout_s:g} s"
        return found[0]

    def all(self, kind: type[T], since: int = 0) -> list[T]:
        """Return every message of ``kind`` heard so far."""
        with self._news:
            return [message for message, _ in self.heard[since:] if isinstance(message, kind)]

    def send(self, kind: Down, message: down.Order, *, retain: bool = False) -> None:
        """Publish one order."""
        self.send_bytes(kind, codec.encode(message), retain=retain)

    def send_bytes(self, kind: Down, payload: bytes, *, retain: bool = False) -> None:
        """Publish any payload on an order's topic."""
        assert self.link.publish(topic(self.robot, kind), payload, qos=1, retain=retain)

    def proof(self, token: int) -> dict[str, Any]:
        """Return lease, sequence and the newest challenge."""
        self.seq += 1
        heartbeat = self.wait(up.Heartbeat, since=self.mark())
        return {"robot": self.robot, "lease_token": token, "lease_seq": self.seq, "challenge": heartbeat.challenge}

    def command(self, action: Any, token: int = 1, **more: Any) -> up.Ack:
        """Send a fresh command and return its answer."""
        order = down.Command(command_id=uuid.uuid4().hex, action=action, by="Martha", **self.proof(token), **more)
        since = self.mark()
        self.send(Down.COMMAND, order)
        return self.wait(up.Ack, lambda ack: ack.ref == order.command_id, since=since)


class Site:
    """A running simulator and its testers' doors."""

    def __init__(self, port: int) -> None:
        self.base_url = f"http://127.0.0.1:{port}"
        self.http = httpx.Client(
            base_url=self.base_url, headers={"Authorization": f"Bearer {TOKEN}"}, trust_env=False, timeout=5
        )

    def fault(self, body: dict[str, Any], robot: str = ROBOT) -> None:
        """Switch a fault on."""
        self.http.post(f"/_faults/{robot}", json=body).raise_for_status()

    def mend(self, name: str = "", robot: str = ROBOT) -> None:
        """Switch a fault off."""
        self.http.delete(f"/_faults/{robot}", params={"fault": name} if name else {}).raise_for_status()

    def truth(self, robot: str = ROBOT) -> dict[str, Any]:
        """Return what is really so."""
        found: dict[str, Any] = self.http.get(f"/_world/{robot}").raise_for_status().json()
        return found

    def until(self, wanted: Callable[[dict[str, Any]], bool], timeout_s: float = WAIT_S) -> dict[str, Any]:
        """Return the truth as soon as it is as wanted."""
        until = time.monotonic() + timeout_s
        while time.monotonic() < until:
            truth = self.truth()
            if wanted(truth):
                return truth
            time.sleep(0.02)
        raise AssertionError(f"still not so after {timeout_s:g} s: {self.truth()}")


def wait_for_retained(url: str, name: str) -> None:
    """Return when the broker hands out a retained message on a topic."""
    found = threading.Event()

    def on_message(_topic: str, payload: bytes, is_retained: bool) -> None:
        if is_retained and payload:
            found.set()

    until = time.monotonic() + WAIT_S
    while not found.is_set() and time.monotonic() < until:
        link = MqttLink(url, f"looker-{uuid.uuid4().hex[:8]}", subscriptions=[(name, 1)], on_message=on_message)
        link.start()
        found.wait(0.5)
        link.stop()
    assert found.is_set(), f"nothing retained on {name}"


@contextlib.contextmanager
def running_simulator(url: str, *, speed: float = 1.0, robot: str = ROBOT, **weeder: Any) -> Iterator[Site]:
    """Run a simulator with one robot, a weeder if nothing is said, on a thread of this process."""
    ready, ports = threading.Event(), []

    def on_ready(port: int) -> None:
        ports.append(port)
        ready.set()

    config = SimulatorConfig(url, (RobotConfig(robot, robot.title(), TOKEN, **weeder),), speed=speed)
    simulator = Simulator(config, on_ready=on_ready)
    thread = threading.Thread(target=lambda: asyncio.run(simulator.run()))
    thread.start()
    try:
        assert ready.wait(WAIT_S)
        site = Site(ports[0])
        yield site
        site.http.close()
    finally:
        simulator.stop()
        thread.join(5)
        assert not thread.is_alive()
