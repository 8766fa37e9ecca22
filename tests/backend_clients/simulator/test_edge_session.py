"""What a robot tells of its inside over the broker: when, how often, and what stays there."""

from __future__ import annotations

import asyncio
from collections import Counter

from backend_clients.edge import codec
from backend_clients.edge import messages_up as up
from backend_clients.edge.machine import Body, Detections, Worksite
from backend_clients.edge.mqtt import LinkState, OnLink, OnMessage, Will
from backend_clients.edge.topics import Up, parse
from backend_clients.simulator.cameras.scene import Box
from backend_clients.simulator.cameras.sight import Sight
from backend_clients.simulator.config import RobotConfig
from backend_clients.simulator.edge_session import TICK_S, EdgeSession
from backend_clients.simulator.faults import NodeFailure
from backend_clients.simulator.links import RobotLink
from tests.backend_clients.simulator.rig import Rig, small_mission


class Wire:
    """A broker that notes what is published; ``drop`` and ``come_back`` break and mend the connection."""

    def __init__(self) -> None:
        self.is_up = True
        self.said: list[tuple[Up, up.Header, bool]] = []
        self._on_link: OnLink = lambda _state, _text: None

    def make(self, _robot: str, _client: str, _on_message: OnMessage, on_link: OnLink, _will: Will) -> RobotLink:
        """Return itself as the link of the robot."""
        self._on_link = on_link
        return self

    def start(self) -> None:
        """Connect."""
        self._on_link(LinkState.UP, "")

    def stop(self) -> None:
        """Leave."""

    def drop(self) -> None:
        """Vanish."""

    def publish(self, topic: str, payload: bytes, *, qos: int = 0, retain: bool = False) -> bool:
        """Note one message."""
        address = parse(topic)
        message = codec.decode_body(address, payload)
        assert isinstance(address.kind, Up)
        assert isinstance(message, up.Header)
        self.said.append((address.kind, message, retain))
        return True

    def count(self) -> Counter[Up]:
        """Return how many of each kind were said since the last call."""
        found = Counter(kind for kind, _, _ in self.said)
        self.said.clear()
        return found


class Stage:
    """One robot with its session on a fake wire and a fake clock."""

    def __init__(self, **config: object) -> None:
        self.rig, self.wire = Rig(**config), Wire()
        self.session = EdgeSession(self.rig.robot, self.wire.make, asyncio.get_running_loop())

    async def run(self, seconds: float) -> Counter[Up]:
        """Let time pass; return what was said."""
        self.wire.count()
        for _ in range(round(seconds / TICK_S)):
            self.rig.run(TICK_S)
            self.session.tick()
            await asyncio.sleep(0)
        return self.wire.count()


async def test_a_body_is_told_twice_a_second_at_rest_and_ten_times_while_joints_move() -> None:
    stage = Stage(family="planter")
    rest = await stage.run(4.0)
    assert rest[Up.BODY] == 8
    assert 3 <= rest[Up.SCAN] <= 4
    stage.rig.do("drive_open")
    moving = 0
    for _ in range(40):
        stage.rig.jog(slew=0.2)
        moving += (await stage.run(0.1))[Up.BODY]
    assert 38 <= moving <= 41


async def test_lean_robots_say_neither_body_nor_scan_nor_site() -> None:
    stage = Stage(is_lean=True)
    said = await stage.run(20.0)
    assert not {Up.BODY, Up.SCAN, Up.WORKSITE} & set(said)


async def test_a_site_is_told_at_each_change_kept_by_the_broker_and_told_again_after_a_reconnect() -> None:
    stage = Stage(family="planter")
    stage.rig.start(small_mission(rows=1, length_m=12.0, width_m=4.0))
    sites: list[Worksite] = []
    for _ in range(400):
        await stage.run(0.0)
        stage.rig.run(0.5)
        stage.session.tick()
        sites += [message for _, message, retain in stage.wire.said if isinstance(message, Worksite) and retain]
        if len(sites) >= 3:
            break
    assert [one.status for one in sites[0].targets][:1] in (["planned"], ["current"])
    assert sites[-1].targets != sites[0].targets
    stage.wire.count()
    stage.wire.start()
    await asyncio.sleep(0)
    stage.session.tick()
    assert any(isinstance(message, Worksite) and retain for _, message, retain in stage.wire.said)


async def test_a_node_is_told_when_its_life_changes_and_every_five_seconds() -> None:
    stage = Stage(family="planter")
    await stage.run(0.5)
    usual = await stage.run(10.0)
    nodes = len(stage.rig.config.profile.nodes)
    assert usual[Up.NODE] == 2 * nodes
    await stage.run(0.2)
    stage.rig.robot.set_fault(NodeFailure(node="crane"))
    stage.rig.run(0.1)
    stage.session.tick()
    told = {m.name: m.state for kind, m, retain in stage.wire.said if isinstance(m, up.Node) and retain and kind}
    assert told["crane"] == "failure"


async def test_the_factsheet_declares_what_the_messages_speak_of() -> None:
    stage = Stage(family="planter")
    await stage.run(0.1)
    sheet = stage.rig.boot.reporter.factsheet()
    body = stage.rig.boot.reporter.body()
    assert isinstance(body, Body)
    assert set(body.joints) == {joint.name for joint in sheet.joints}
    assert sheet.chart is not None
    assert {one.id for one in stage.rig.state.active} <= {one.id for one in sheet.chart.states}
    assert RobotConfig("a", "A", "t", family="planter").profile.nodes[0].name in {node.name for node in sheet.nodes}


async def test_what_cameras_found_is_told_twice_a_second_a_camera_and_only_while_pictures_are_fetched() -> None:
    stage = Stage()
    assert Up.DETECTIONS not in await stage.run(2.0)
    box = Box("weed", -0.01, 0.5, 0.1, 0.1, 1.2, hit=True)
    told: list[Detections] = []
    for _ in range(40):
        now_s = stage.rig.clock.mono_s()
        for camera in ("front", "tool"):
            stage.rig.robot.sights[camera] = Sight(camera, now_s, 1, [box])
        stage.wire.said.clear()
        stage.rig.run(0.05)
        stage.session.tick()
        told += [m for _, m, _ in stage.wire.said if isinstance(m, Detections)]
    assert 3 <= sum(one.camera == "front" for one in told) <= 4
    assert 3 <= sum(one.camera == "tool" for one in told) <= 4
    assert (told[0].boxes[0].x, told[0].boxes[0].score) == (0.0, 1.0)
    await stage.run(1.5)
    assert Up.DETECTIONS not in await stage.run(2.0)
