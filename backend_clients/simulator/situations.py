"""Situations of a working farm that can be played on a robot: what they are called and which faults make them."""

from __future__ import annotations

from dataclasses import dataclass

from backend_clients.simulator import faults
from backend_clients.simulator.faults import Fault
from backend_clients.simulator.profile import Family

ALL: tuple[Family, ...] = ("weeder", "planter", "uav")
GROUND: tuple[Family, ...] = ("weeder", "planter")


@dataclass(frozen=True, slots=True)
class Situation:
    """One situation.

    Args:
        text: what happens, in one sentence.
        families: to which machines it can happen.
        lasts_s: how long it lasts when the farm plays it by itself.
        weight: how often the farm plays it by itself; 0 never.
    """

    id: str
    title: str
    text: str
    families: tuple[Family, ...]
    fault: Fault
    lasts_s: tuple[float, float] = (60.0, 120.0)
    weight: float = 0.0


SITUATIONS = (
    Situation(
        "person-ahead",
        "Somebody in the way",
        "Somebody stands in front of it: it waits, and goes on after the horn when the way is free.",
        GROUND,
        faults.PersonAhead(distance_m=3.0),
        (40.0, 100.0),
        2.0,
    ),
    Situation(
        "weed-unsure",
        "Weed or crop?",
        "It cannot tell crop and weed apart and waits for a person to look.",
        ("weeder",),
        faults.WeedUnsure(),
        (90.0, 240.0),
        3.0,
    ),
    Situation(
        "rtk-float",
        "RTK float",
        "Its position is no longer exact: it waits until RTK is fixed.",
        GROUND,
        faults.RtkFloat(),
        (60.0, 180.0),
        3.0,
    ),
    Situation(
        "crane-limit",
        "Crane outside its limit",
        "The crane reached its limit: retract it, or move it by hand.",
        ("planter",),
        faults.CraneLimit(),
        (120.0, 300.0),
        3.0,
    ),
    Situation(
        "tray-empty",
        "No seedlings left",
        "The tray is empty: the planter waits for a new one.",
        ("planter",),
        faults.TrayEmpty(),
        (60.0, 150.0),
        1.0,
    ),
    Situation(
        "person-near",
        "Somebody near",
        "Somebody walks by: crane and drive go on at half their speed.",
        ("planter",),
        faults.PersonAhead(distance_m=9.0),
        (30.0, 80.0),
        1.0,
    ),
    Situation(
        "node-failure",
        "Crane controller fails",
        "A part of its software fails: the mission is paused until an admin restarts it.",
        ("planter",),
        faults.NodeFailure(node="crane"),
    ),
    Situation(
        "gnss-failure",
        "RTK receiver fails",
        "The receiver's software fails: the robot no longer knows where it is and pauses.",
        ALL,
        faults.NodeFailure(node="gnss"),
    ),
    Situation(
        "node-silent",
        "A node falls silent",
        "Nothing is heard of its RTK receiver's software; it goes on.",
        ALL,
        faults.NodeSilent(node="gnss"),
    ),
    Situation(
        "node-slow",
        "A node is slow",
        "Its RTK receiver's software runs at 40 % of its usual rate.",
        ALL,
        faults.NodeSlow(node="gnss"),
    ),
    Situation(
        "clock-skew",
        "A clock is wrong",
        "The clock of its RTK receiver's computer is 0.85 s ahead.",
        ALL,
        faults.ClockSkew(node="gnss"),
    ),
    Situation(
        "start-order",
        "Started in the wrong order",
        "The planting head was started before the crane controller it needs; restarting it helps.",
        ("planter",),
        faults.WrongStartOrder(node="planter"),
    ),
    Situation(
        "no-link",
        "No link",
        "Its radio is silent: nothing is heard of it and it hears nothing; at work it pauses by itself after 10 s.",
        ALL,
        faults.Silence(http=True, deaf=True),
        (25.0, 60.0),
        1.0,
    ),
    Situation(
        "slow-link",
        "Slow link",
        "Its radio is slow and loses some messages: values come late.",
        ALL,
        faults.Packets(delay_s=0.3, jitter_s=0.4, drop=0.1),
        (60.0, 120.0),
        1.0,
    ),
    Situation(
        "low-battery",
        "Low battery",
        "Its battery falls to 19 %: it should come home soon.",
        GROUND,
        faults.LowBattery(soc=0.19),
        (600.0, 900.0),
        0.2,
    ),
    Situation(
        "reserve-near",
        "Battery near its reserve",
        "Its battery falls to 27 %: at 25 % it flies home by itself.",
        ("uav",),
        faults.LowBattery(soc=0.27),
        (300.0, 600.0),
    ),
    Situation(
        "tool-interlock",
        "Cover open",
        "The cover of its tool is open: the tool stays off and the robot waits.",
        GROUND,
        faults.ToolInterlock(),
    ),
    Situation(
        "hardware-stop",
        "Red button pressed",
        "Somebody pressed the red button on the machine: it stands until the button is released there.",
        ALL,
        faults.HardwareStop(),
    ),
    Situation(
        "brakes-fail",
        "Brakes fail",
        "It acknowledges STOP and pause and drives on: STOP is not confirmed.",
        ALL,
        faults.KeepsMoving(),
    ),
    Situation(
        "camera-freeze",
        "Cameras hang",
        "Its cameras keep their connections and send no pictures; it goes on.",
        ALL,
        faults.CameraFreeze(),
    ),
    Situation(
        "camera-garbage",
        "Broken pictures",
        "Its cameras send pictures that cannot be read; it goes on.",
        ALL,
        faults.CameraGarbage(),
    ),
    Situation(
        "restart",
        "Computer restarts",
        "Its computer goes off and starts again after 15 s: the mission comes back paused.",
        ALL,
        faults.Crash(reboot_after_s=15.0),
    ),
)
BY_ID = {one.id: one for one in SITUATIONS}
