"""Who keeps account of robots: a fault over one of them keeps nothing from the others."""

from __future__ import annotations

from hmi.app.witness import FleetWitness
from hmi.domain.robot import Robot
from tests.hmi.live.rig import HubRig


def test_a_fault_over_one_robot_keeps_neither_others_nor_their_return_from_whoever_keeps_account() -> None:
    rig = HubRig("bad", "weeder-02")
    back: list[str] = []
    seen: list[str] = []

    def returned(robot_id: str) -> None:
        back.append(robot_id)
        if robot_id == "bad":
            raise RuntimeError("a fault of ours")

    def fails(robot: Robot) -> None:
        if robot.id == "bad":
            raise RuntimeError("a fault of ours")

    FleetWitness(rig.store, rig.clock, returned, [fails, lambda robot: seen.append(robot.id)]).start()
    for robot_id in ("bad", "weeder-02"):
        rig.store.put_heartbeat(robot_id, boot="b", challenge="c", heard_s=rig.clock.mono_s())
    rig.store.announce()
    assert sorted(back) == ["bad", "weeder-02"]
    assert sorted(seen) == ["bad", "weeder-02"]
