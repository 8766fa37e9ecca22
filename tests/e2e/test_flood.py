"""500 alarms in ten seconds over the wire of the demo: the list stays readable, and what came first is named."""

from __future__ import annotations

import re
import time
from collections.abc import Callable, Iterator
from typing import Any
from urllib.parse import urlsplit

import paho.mqtt.client as mqtt
import pytest
from playwright.sync_api import expect

from backend_clients.edge import messages_up as up
from backend_clients.edge.codec import encode
from backend_clients.edge.topics import Up, topic
from tests.e2e.caller import Caller
from tests.e2e.installation import Installation
from tests.e2e.person import Person, wait_for

pytestmark = [pytest.mark.browser, pytest.mark.long]
Come = Callable[..., Person]
TROUBLED = tuple(f"troubled-{number:02}" for number in range(1, 11))
EACH, ROUNDS, ROUND_S = 50, 20, 0.5
CAUSE, FOLLOWS = "battery-low", "battery-very-low"


class Troubled:
    """Robots of another maker that report more faults at each round; on the demo's own broker."""

    def __init__(self, url: str) -> None:
        where = urlsplit(url)
        self._client = mqtt.Client(mqtt.CallbackAPIVersion.VERSION2, protocol=mqtt.MQTTv311)
        self._client.connect(where.hostname or "127.0.0.1", where.port or 1883)
        self._client.loop_start()
        self._seq, self._started_s = 0, time.monotonic()

    def report(self, count: int) -> None:
        """Let every robot report its first ``count`` faults; the first is the cause of the second."""
        codes = [CAUSE, FOLLOWS, *(f"fault-{number:02}" for number in range(EACH))][:count]
        faults = [up.Fault(code=code, level="medium", text=f"It says {code}.") for code in codes]
        for robot in TROUBLED:
            self._say(robot, Up.HEARTBEAT, up.Heartbeat(**self._head(robot), challenge="challenge-1"), 0)
            state = up.State(**self._head(robot), mode="idle", path=["Idle"], path_since_ms=0, faults=faults)
            self._say(robot, Up.STATE, state, 1)

    def _head(self, robot: str) -> dict[str, Any]:
        self._seq += 1
        mono_ms = int(1000 * (time.monotonic() - self._started_s))
        return {"robot": robot, "boot": "boot-0001", "seq": self._seq, "mono_ms": mono_ms,
                "wall_ms": int(1000 * time.time())}  # fmt: skip

    def _say(self, robot: str, kind: Up, message: up.Header, qos: int) -> None:
        self._client.publish(topic(robot, kind), encode(message), qos=qos).wait_for_publish(5)

    def end(self) -> None:
        """Leave the broker."""
        self._client.loop_stop()
        self._client.disconnect()


@pytest.fixture
def troubled(calm: Installation) -> Iterator[Troubled]:
    """Ten more robots, taken out again afterwards."""
    admin = Caller(calm.url, "admin")
    for robot in TROUBLED:
        admin.post("/robots", {"id": robot, "name": robot.replace("-", " ").title()}).raise_for_status()
    robots = Troubled(calm.health()["parts"]["broker"]["url"])
    yield robots
    robots.end()
    for robot in TROUBLED:
        admin.delete(f"/robots/{robot}")
    admin.close()


def test_five_hundred_alarms_in_ten_seconds_stay_readable_and_name_what_came_first(
    person: Come, calm: Installation, troubled: Troubled
) -> None:
    caller = Caller(calm.url, "supervisor")
    anna = person("supervisor", size="desk")
    anna.open("/alarms")
    anna.sees("stop", "ready")
    for step in range(1, ROUNDS + 1):
        begun_s = time.monotonic()
        troubled.report(max(1, EACH * step // ROUNDS) if step > 2 else step)
        anna.page.wait_for_timeout(max(0.0, 1000 * (ROUND_S - (time.monotonic() - begun_s))))

    def listed() -> dict[str, dict[str, Any]]:
        return {one["id"]: one for one in caller.get("/alarms")["alarms"]}

    def is_whole() -> bool:
        troubled.report(EACH)
        return sum(one["source"] in TROUBLED for one in listed().values()) >= EACH * len(TROUBLED)

    wait_for(is_whole, within_s=20, what="every fault is an alarm")
    expect(anna.hook("alarm-flood")).to_contain_text(re.compile(r"Flood: \d{3} alarms in 10 min"), timeout=10_000)
    found = listed()
    for robot in TROUBLED:
        assert found[f"{CAUSE}.{robot}"]["place"] == 1
        assert found[f"{FOLLOWS}.{robot}"]["first"] == f"{CAUSE}.{robot}"
    row = anna.hook(f"alarm-row-{CAUSE}.{TROUBLED[0]}")
    expect(row).to_contain_text("First out, 1 of 2")
    assert anna.page.locator(".al-rows .al-row").count() < 60, "only what is in sight is in the page"
    anna.hook(f"alarm-ack-{CAUSE}.{TROUBLED[0]}").click()
    anna.sees(f"alarm-row-{CAUSE}.{TROUBLED[0]}", "acknowledged")
    anna.sees("stop", "ready")
    assert anna.covers_of_stop() == []
    caller.close()
