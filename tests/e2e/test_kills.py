"""Any process may be killed at any moment: STOP still stops, and what was asked meanwhile never acts later."""

from __future__ import annotations

import os
import random
import signal
from collections.abc import Callable

import pytest

from tests.e2e.installation import Installation
from tests.e2e.person import Person, wait_for
from tests.e2e.test_farmer import send_mission

pytestmark = pytest.mark.browser
Come = Callable[..., Person]
ROBOT = "weeder-01"
PARTS = ("console", "stop", "broker")
LONG_ROUNDS = 100


def kill_and_stop(martha: Person, calm: Installation, part: str, wait_ms: int = 0) -> None:
    """Kill a part with the robot driving, press STOP, and watch until everything is back."""
    restarts = calm.keeper()[part]["restarts"]
    os.kill(calm.pid(part), signal.SIGKILL)
    martha.page.wait_for_timeout(wait_ms)
    martha.press_stop()
    wait_for(lambda: calm.world(ROBOT)["latched"], within_s=8, what=f"stopped while {part} is dead")
    wait_for(lambda: calm.world(ROBOT)["standstill"], within_s=4, what=f"it stands while {part} is dead")
    stood_m = calm.world(ROBOT)["distance_m"]
    wait_for(lambda: calm.keeper()[part]["restarts"] > restarts, within_s=10, what=f"{part} is started again")
    wait_for(lambda: calm.keeper()[part]["state"] == "ok", within_s=40, what=f"{part} serves again")
    martha.sees("stop", "standstill", within_s=20)
    martha.sees("link-banner", "ok", within_s=40)
    assert calm.world(ROBOT)["latched"]
    assert calm.world(ROBOT)["distance_m"] == pytest.approx(stood_m, abs=1e-6)


def let_it_drive(martha: Person, calm: Installation) -> None:
    """Start the stored mission and wait until the robot is under way."""
    send_mission(martha)
    martha.operate(ROBOT)
    martha.slide_into("mission-start", "auto")  # locked until its nodes are heard
    wait_for(lambda: calm.world(ROBOT)["speed_mps"] > 0.1, within_s=20, what="it drives")


# a dead broker is also part of test_stop
@pytest.mark.parametrize("part", ["console", "stop", pytest.param("broker", marks=pytest.mark.long)])
def test_stop_works_while_a_part_is_dead_and_nothing_moves_when_it_is_back(
    person: Come, calm: Installation, part: str
) -> None:
    martha = person("operator")
    let_it_drive(martha, calm)
    kill_and_stop(martha, calm, part)


@pytest.mark.long
@pytest.mark.timeout(7200)
def test_a_hundred_kills_at_any_moment(person: Come, calm: Installation) -> None:
    moments = random.Random(2026)
    martha = person("operator")
    for _ in range(LONG_ROUNDS):
        calm.calm()
        let_it_drive(martha, calm)
        kill_and_stop(martha, calm, moments.choice(PARTS), wait_ms=moments.randrange(0, 3000))


@pytest.mark.long
def test_a_start_asked_while_the_broker_is_dead_never_acts(person: Come, calm: Installation) -> None:
    martha = person("operator")
    send_mission(martha)
    martha.operate(ROBOT)
    martha.tick_list()
    before_m = calm.world(ROBOT)["distance_m"]
    os.kill(calm.pid("broker"), signal.SIGSTOP)
    try:
        martha.slide_into("mission-start", "auto")  # locked until its nodes are heard
        martha.page.wait_for_timeout(3000)
    finally:
        os.kill(calm.pid("broker"), signal.SIGCONT)
    martha.page.wait_for_timeout(5000)
    assert calm.world(ROBOT)["distance_m"] == pytest.approx(before_m, abs=1e-6)
    assert calm.world(ROBOT)["mode"] != "auto"
