"""One robot, one pair of hands: control, hold-to-run, and what happens when the hands vanish."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from playwright.sync_api import expect

from tests.e2e.installation import Installation
from tests.e2e.person import Person, wait_for

pytestmark = pytest.mark.browser
Come = Callable[..., Person]
ROBOT = "weeder-01"
DEADMAN_S = 0.5
BRAKING_S = 0.5  # from creep speed, with the simulator's deceleration and its 20 Hz steps
SLOW_MACHINE_S = 1.0  # scheduling of two cores under load; the dead-man itself is measured in the simulator


def hold_forward(martha: Person, calm: Installation) -> None:
    """Hold forward until the robot moves; a press made while the screen was too slow is refused and made anew."""
    before = calm.world(ROBOT)["distance_m"]
    for _ in range(4):
        martha.hold("drive-forward")
        try:
            wait_for(lambda: calm.world(ROBOT)["distance_m"] > before + 0.1, within_s=3, what="it drives")
        except AssertionError:
            martha.let_go()
        else:
            return
    raise AssertionError(f"it does not drive: {martha.hook('drive-forward').inner_text()}")


def drive_forward(martha: Person, calm: Installation) -> None:
    """Open manual driving and hold forward until the robot really moves."""
    martha.operate(ROBOT)
    martha.order("drive-open", into="manual")
    hold_forward(martha, calm)


def stands_within_dead_man(calm: Installation) -> None:
    """The simulator's own measure: from the last setpoint it accepted to standstill."""
    wait_for(lambda: calm.world(ROBOT)["standstill"], within_s=DEADMAN_S + BRAKING_S + SLOW_MACHINE_S, what="it stands")
    took_s = calm.world(ROBOT)["setpoint_to_standstill_s"]
    assert took_s is not None
    assert took_s <= DEADMAN_S + BRAKING_S


def test_lifting_the_finger_stops_the_robot(person: Come, calm: Installation) -> None:
    martha = person("operator")
    drive_forward(martha, calm)
    martha.let_go()
    stands_within_dead_man(calm)


@pytest.mark.long
def test_a_hidden_tab_stops_the_robot(person: Come, calm: Installation) -> None:
    martha = person("operator")
    drive_forward(martha, calm)
    martha.page.evaluate(
        """() => {
            Object.defineProperty(document, 'visibilityState', {value: 'hidden', configurable: true});
            Object.defineProperty(document, 'hidden', {value: true, configurable: true});
            document.dispatchEvent(new Event('visibilitychange'));
        }"""
    )
    stands_within_dead_man(calm)


def test_a_dead_browser_stops_the_robot(person: Come, calm: Installation) -> None:
    martha = person("operator")
    drive_forward(martha, calm)
    martha.context.close()
    stands_within_dead_man(calm)


def test_a_network_that_dies_while_driving_stops_the_robot(person: Come, calm: Installation) -> None:
    martha = person("operator")
    drive_forward(martha, calm)
    calm.fault(ROBOT, "packets", direction="down", drop=1.0)
    stands_within_dead_man(calm)


def test_two_operators_race_and_only_one_gets_the_robot(person: Come, calm: Installation) -> None:
    martha, anna = person("operator"), person("dispatcher")
    for someone in (martha, anna):
        someone.operate(ROBOT)
    martha.hook("lease-request").click()
    expect(martha.hook("lease-owner")).to_contain_text("You have control")
    expect(anna.hook("lease-owner")).to_contain_text("Martha Keller has control")
    anna.hook("lease-request").click()
    expect(martha.hook("lease-grant")).to_be_visible()
    martha.hook("lease-grant").click()
    expect(anna.hook("lease-owner")).to_contain_text("You have control")
    expect(martha.hook("lease-owner")).to_contain_text("Tomas Lind has control")


def test_clicks_made_offline_never_act(person: Come, calm: Installation) -> None:
    martha = person("operator")
    martha.operate(ROBOT)
    before = calm.world(ROBOT)
    martha.context.set_offline(True)
    martha.sees("link-banner", "server-lost", within_s=10)
    for hook in ("lease-request", "mission-pause", "drive-open"):
        if martha.hook(hook).count() and martha.hook(hook).is_enabled():
            martha.hook(hook).click(force=True)
    martha.context.set_offline(False)
    martha.sees("link-banner", "ok", within_s=20)
    expect(martha.hook("lease-owner")).to_contain_text("Nobody has control")
    assert calm.world(ROBOT)["mode"] == before["mode"]
