"""A planter, a UAV and lean robots keep edge contract v1 over a real broker."""

from __future__ import annotations

import uuid

import pytest

from backend_clients.edge import messages_down as down
from backend_clients.edge import messages_up as up
from backend_clients.edge.topics import Down
from tests.backend_clients.simulator.rig import small_mission
from tests.contract.wire import Listener, running_simulator

pytestmark = pytest.mark.broker
PLACE = {"datum_lat_deg": 52.0, "datum_lon_deg": 5.0, "y_m": -2.0, "theta_rad": 1.5708}


@pytest.mark.parametrize(
    "broker", ["mosquitto", pytest.param("amqtt", marks=pytest.mark.long)], indirect=True, scope="session"
)
@pytest.mark.parametrize(
    ("robot", "family", "is_lean"),
    [("planter-01", "planter", False), ("uav-01", "uav", False), ("lean-0001", "weeder", True)],
)
def test_it_works_stops_and_is_reset_as_every_robot(broker: str, robot: str, family: str, is_lean: bool) -> None:
    with (
        running_simulator(broker, robot=robot, family=family, is_lean=is_lean, link_lost_pause_s=60.0, **PLACE),
        Listener(broker, robot) as listener,
    ):
        # amqtt hands a new client what other robots left retained, too
        assert listener.wait(up.Factsheet, lambda f: f.robot == robot).family == family
        assert listener.wait(up.Node, lambda n: n.robot == robot).state == "started"
        assert listener.wait(up.Heartbeat).challenge
        mission = small_mission(robot, length_m=60.0)
        listener.send(Down.MISSION, mission)
        stored = listener.wait(up.Ack, lambda a: a.kind == "mission")
        assert stored.outcome == "accepted"
        listener.command("start", mission_id=mission.mission_id, mission_sha256=stored.sha256, is_supervised=False)
        listener.wait(up.Telemetry, lambda t: t.speed_mps > 0.5, timeout_s=40.0)  # a UAV climbs first
        since, stop_id = listener.mark(), uuid.uuid4().hex
        listener.send(Down.STOP, down.Stop(robot=robot, stop_id=stop_id, by="Martha"))
        assert listener.wait(up.Ack, lambda a: a.ref == stop_id, since=since).outcome == "accepted"
        safety = listener.wait(up.Safety, lambda s: s.latched and s.standstill, since=since)
        assert safety.tool_off
        assert listener.wait(up.State, lambda s: s.mode == "stopped", since=since).lease_token == 0
        told = [m for m in listener.all(up.Header, since) if isinstance(m, (up.Telemetry, up.Safety, up.State))]
        assert {m.robot for m in told} == {robot}
