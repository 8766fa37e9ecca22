"""The media process at work with a real viser server: what a viewer's picture holds, and whom it answers."""

from __future__ import annotations

import asyncio
import urllib.error
import urllib.request
from collections.abc import AsyncIterator
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest
import websockets.asyncio.client
import zstandard
from websockets.exceptions import InvalidStatus
from websockets.typing import Subprotocol

from backend_clients.edge import machine
from backend_clients.edge import messages_up as up
from backend_clients.edge.codec import encode
from backend_clients.edge.machine import Joint, Sighting, Target, Worksite
from backend_clients.edge.topics import Up, topic
from hmi.clock import FakeClock, SystemClock
from hmi.media import orders
from hmi.media.control import control_app
from hmi.media.door import RIGHTS_HEADER, SECRET_HEADER, VIEWER_HEADER
from hmi.media.intake import Intake
from hmi.media.models import ModelShelf
from hmi.media.status import status_of
from hmi.media.studio import Studio
from hmi.media.tap import tapped
from hmi.twin.camera import Camera
from hmi.twin.farm import Farm, FarmRobot, Plan, Treated
from hmi.twin.groups import Group
from hmi.twin.viewer import View
from tests.hmi.app.asgi_socket import AsgiSocket

SECRET = "the secret of this test"
ROBOT, OTHER = "planter-02", "planter-03"
HEADER: dict[str, Any] = {"robot": ROBOT, "boot": "boot-0001", "wall_ms": 0}
JOINTS = [
    Joint(name="slew", label="1 Slew", lower=-3.0, upper=3.0, max_rate=0.4),
    Joint(name="stick", label="3 Stick", lower=-2.7, upper=-0.15, soft_lower=-2.57, soft_upper=-0.28, max_rate=0.3),
]


class Planter:
    """A planter that speaks when told."""

    def __init__(self, intake: Intake, robot: str = ROBOT) -> None:
        self._intake, self._mono_ms, self._robot = intake, 0, robot

    def say(self, kind: Up, form: type[up.Header], **values: Any) -> None:
        """Say something."""
        self._mono_ms += 100
        message = form(**HEADER | {"robot": self._robot}, seq=self._mono_ms, mono_ms=self._mono_ms, **values)
        self._intake.take(topic(self._robot, kind), encode(message), False)

    def rest(self, seconds: float) -> None:
        """Let its clock run."""
        self._mono_ms += round(1000 * seconds)

    def stand(self, x_m: float, slew: float = 0.0, stick: float = -1.0) -> None:
        """Stand somewhere, the crane so."""
        place = {"lat_deg": 52.0, "lon_deg": 5.0, "x_m": x_m, "y_m": 0.0, "theta_rad": 0.0, "speed_mps": 0.0}
        self.say(Up.TELEMETRY, up.Telemetry, **place)
        near = Sighting(id="p1", kind="person", x_m=x_m + 5, y_m=0.0, distance_m=5.0)
        joints = {"slew": slew, "stick": stick}
        self.say(Up.BODY, machine.Body, joints=joints, planned={"slew": slew + 0.3}, seen=[near])

    def introduce(self, **more: Any) -> None:
        """Say who it is."""
        size = up.Dimensions(length_m=6.4, width_m=2.6, height_m=3.2, base_to_front_m=4.0)
        limits = up.Limits(max_speed_mps=2.0, max_accel_mps2=1.0, decel_mps2=1.0, max_yaw_rate_radps=1.0)
        self.say(
            Up.FACTSHEET, up.Factsheet, family="planter", name="Planter 02", model="Planter", software="1",
            datum=up.Datum(lat_deg=52.0, lon_deg=5.0), dimensions=size, limits=limits, joints=JOINTS, **more,
        )  # fmt: skip


class Picture:
    """A browser's picture: nodes as viser's client would hold them."""

    def __init__(self, socket: websockets.asyncio.client.ClientConnection) -> None:
        self._socket = socket
        self.nodes: dict[str, dict[str, Any]] = {}

    async def look(self) -> None:
        """Say where the camera is, as a browser does at first."""
        camera = {
            "type": "ViewerCameraMessage", "wxyz": (1.0, 0.0, 0.0, 0.0), "position": (3.0, 3.0, 3.0), "fov": 1.0,
            "near": 0.01, "far": 1000.0, "look_at": (0.0, 0.0, 0.0), "up_direction": (0.0, 0.0, 1.0),
            "image_height": 600, "image_width": 800,
        }  # fmt: skip
        await self._socket.send(msgspec.msgpack.encode(camera))

    async def until(self, name: str, is_so: Any = lambda node: True) -> dict[str, Any]:
        """Wait for a node to be as wanted."""
        async with asyncio.timeout(10):
            while name not in self.nodes or not is_so(self.nodes[name]):
                self._take(bytes(await self._socket.recv()))  # type: ignore[arg-type]
        return self.nodes[name]

    def _take(self, frame: bytes) -> None:
        size, packed = int.from_bytes(frame[:8], "little"), int.from_bytes(frame[8:16], "little")
        data = zstandard.ZstdDecompressor().decompress(frame[16 : 16 + packed], max_output_size=size)
        for message in msgspec.msgpack.decode(data)["messages"]:
            name, kind = message.get("name"), message["type"]
            if name is None:
                continue
            key = f"{message.get('owner', '')}:{name}" if message.get("owner") else name
            if kind == "RemoveSceneNodeMessage":
                self.nodes.pop(key, None)
            elif kind in ("SetPositionMessage", "SetOrientationMessage", "SetSceneNodeVisibilityMessage"):
                self.nodes.setdefault(key, {}).update(message)
            else:
                self.nodes[key] = {**self.nodes.get(key, {}), **message}


@pytest.fixture
async def studio(tmp_path: Path) -> AsyncIterator[Studio]:
    """A studio whose planter has introduced itself."""
    made = Studio(Intake(SystemClock()), tmp_path, SECRET, SystemClock())
    made.start()
    made.set_farm(Farm([FarmRobot(ROBOT, "Planter 02", 6.2)]))
    yield made
    await made.stop()


async def connect(studio: Studio, key: str, secret: str = SECRET) -> websockets.asyncio.client.ClientConnection:
    """Open a picture as the console does."""
    return await websockets.asyncio.client.connect(
        f"ws://127.0.0.1:{studio.viser_port}/",
        additional_headers={SECRET_HEADER: secret, VIEWER_HEADER: key},
        subprotocols=[Subprotocol("viser-v1.1.1")],
        max_size=64 * 2**20,
        compression=None,
        proxy=None,
    )


async def test_without_the_secret_neither_picture_nor_page_is_given(studio: Studio) -> None:
    with pytest.raises(InvalidStatus) as refused:
        await connect(studio, "k", "guess")
    assert refused.value.response.status_code == 403
    with pytest.raises(urllib.error.HTTPError) as page:
        await asyncio.to_thread(urllib.request.urlopen, f"http://127.0.0.1:{studio.viser_port}/")
    assert page.value.code == 403
    page.value.close()


async def test_a_robot_moves_in_the_picture_with_its_joints_its_ghost_and_its_warnings(studio: Studio) -> None:
    planter = Planter(studio.intake)
    planter.introduce()
    planter.stand(10.0)
    studio.enter("k", ROBOT, may_replay=False)
    async with await connect(studio, "k") as socket:
        picture = Picture(socket)
        await picture.look()
        await picture.until(f"/machine/{ROBOT}", lambda node: node.get("position", [0])[0] == pytest.approx(10.0))
        await picture.until(f"/planned/{ROBOT}/column", lambda node: "wxyz" in node)
        await picture.until(f"/keepout/{ROBOT}/ring")
        await picture.until(f"/labels/{ROBOT}/p1/text", lambda node: "inside keep-out" in str(node))
        planter.stand(11.5, slew=1.0, stick=-2.65)
        await picture.until(f"/machine/{ROBOT}", lambda node: node.get("position", [0])[0] == pytest.approx(11.5))
        await picture.until(f"/machine/{ROBOT}/column", lambda node: node.get("type") == "SetOrientationMessage")
        marked = await picture.until(f"/limits/{ROBOT}/stick/text")
        assert "beyond soft limit" in str(marked)


async def test_the_camera_stands_at_a_robot_that_was_not_heard_before_somebody_looked(studio: Studio) -> None:
    studio.enter("k", ROBOT, may_replay=False)
    async with await connect(studio, "k") as socket:
        picture = Picture(socket)
        await picture.look()
        async with asyncio.timeout(5):
            while (client := studio.viewers["k"].client) is None:  # noqa: ASYNC110 - viser's thread hands over
                await asyncio.sleep(0.01)
        planter = Planter(studio.intake)
        planter.introduce()
        planter.stand(160.0)
        await picture.until(f"/machine/{ROBOT}", lambda node: node.get("position", [0])[0] == pytest.approx(160.0))
        async with asyncio.timeout(5):
            while abs(client.camera.position[0] - 160.0) > 15.0:  # noqa: ASYNC110 - set between two ticks
                await asyncio.sleep(0.01)
        assert client.camera.look_at[0] == pytest.approx(160.0, abs=1.0)


async def test_a_camera_that_a_loading_page_put_elsewhere_is_put_back_until_the_person_takes_it(studio: Studio) -> None:
    async with await connect(studio, "nobody's: the studio leaves it alone") as socket:
        picture = Picture(socket)
        await picture.look()
        async with asyncio.timeout(5):
            while not (clients := studio.server.get_clients()):  # noqa: ASYNC110 - viser's thread makes it
                await asyncio.sleep(0.01)
        client = next(iter(clients.values()))
        camera, held = Camera(client), client.camera
        camera.stand((160.0, 5.0, 8.0), (160.0, 0.0, 1.0), 10.0)
        await reported(picture, held)  # it stands where every page begins: what was ordered got lost
        camera.check(10.1)
        assert held.position[0] == 3.0, "a report may be older than the order"
        camera.check(10.6)
        assert list(held.position) == [160.0, 5.0, 8.0]
        assert list(held.look_at) == [160.0, 0.0, 1.0]
        await reported(picture, held)
        camera.carry(np.array([1.0, 0.0, 0.0]))
        assert list(held.position) == [161.0, 5.0, 8.0], "it is carried from where it was ordered"
        assert list(held.look_at) == [161.0, 0.0, 1.0]
        camera.let_go()
        await reported(picture, held)
        camera.check(20.0)
        camera.carry(np.array([1.0, 0.0, 0.0]))
        assert list(held.position) == [4.0, 3.0, 3.0], "from where the person left it"


async def reported(picture: Picture, camera: Any) -> None:
    """Let the browser say that its camera stands where every page begins."""
    await picture.look()
    async with asyncio.timeout(5):
        while camera.position[0] != 3.0:  # noqa: ASYNC110 - viser's thread takes it
            await asyncio.sleep(0.005)


async def test_a_place_is_shown_with_the_height_of_the_tool_and_says_how_far_the_arm_reaches(studio: Studio) -> None:
    planter = Planter(studio.intake)
    planter.introduce()
    planter.stand(0.0)
    box = studio.enter("k", ROBOT, may_replay=False)
    current = [Target(id="tree-147", x_m=-5.0, y_m=0.0, status="current")]
    planter.say(Up.WORKSITE, Worksite, stop=1, targets=current, obstacles=[])
    async with await connect(studio, "k") as socket:
        picture = Picture(socket)
        await picture.look()
        assert "Reach" in str(await picture.until(f"/reach/{ROBOT}/line/text"))
        assert "Tree 147" in str(await picture.until(f"/trees/{ROBOT}/now/named/text"))
        studio.touch("k", (-5.0, 0.4, 9.0), (0.0, 0.0, -1.0))
        studio.obey("k", orders.Lift(1.6))
        owner = str(studio.viewers["k"].client.client_id)  # type: ignore[union-attr]
        assert "1.6 m" in str(await picture.until(f"{owner}:/touched/text"))
        async with asyncio.timeout(5):
            while (said := await box.get())["k"] != "tap":
                assert said["k"] == "status"
        assert said["what"] == "place"
        assert said["arm_m"] == pytest.approx(3.22, abs=0.02)
        assert said["reach_m"] > said["arm_m"]


async def test_what_was_planted_stays_when_the_surface_is_reset_at_the_next_stop(studio: Studio) -> None:
    planter = Planter(studio.intake)
    planter.introduce()
    planter.stand(0.0)
    box = studio.enter("k", ROBOT, may_replay=False)
    first = [Target(id=f"t{i}", x_m=i, y_m=1.0, status="done") for i in range(3)]
    planter.say(Up.WORKSITE, Worksite, stop=1, targets=first, obstacles=[])
    async with await connect(studio, "k") as socket:
        picture = Picture(socket)
        await picture.look()
        await picture.until(f"/trees/{ROBOT}/done", lambda node: "props" in node)
        planned = [
            Target(id="t9", x_m=9.0, y_m=1.0, status="planned"),
            Target(id="t8", x_m=8, y_m=1, status="failed_ground"),
        ]
        planter.say(Up.WORKSITE, Worksite, stop=2, targets=planned, obstacles=[])
        await picture.until(f"/trees/{ROBOT}/failed_ground")
        await picture.until(f"/trees/{ROBOT}/now/planned")
        async with asyncio.timeout(5):
            while (said := await box.get()).get("trees") != {"done": 3, "failed": 1, "here": 1}:
                assert said["k"] == "status"


async def test_hiding_a_layer_and_replaying_reach_one_viewer_only(studio: Studio) -> None:
    planter = Planter(studio.intake)
    planter.introduce()
    planter.stand(10.0)
    studio.enter("mine", ROBOT, may_replay=True)
    studio.enter("other", ROBOT, may_replay=False)
    async with await connect(studio, "mine") as one, await connect(studio, "other") as two:
        mine, other = Picture(one), Picture(two)
        await mine.look()
        await other.look()
        await mine.until(f"/machine/{ROBOT}")
        await other.until(f"/machine/{ROBOT}")
        past = orders.Replay(52.0, 5.001, 0.5, {"slew": 2.0})
        studio.obey("other", past)  # has no right to
        studio.obey("mine", orders.SetLayer(Group.TREES, False))
        studio.obey("mine", past)
        owner = str(studio.viewers["mine"].client.client_id)  # type: ignore[union-attr]
        shown = await mine.until(f"{owner}:/machine/{ROBOT}", lambda node: "position" in node)
        assert shown["position"][0] == pytest.approx(68.6, abs=0.5)
        await mine.until(f"{owner}:/trees")
        studio.obey("mine", orders.Live())
        planter.stand(12.0)
        await other.until(f"/machine/{ROBOT}", lambda node: node.get("position", [0])[0] == pytest.approx(12.0))
        assert not [name for name in other.nodes if ":" in name and not name.endswith("/ground")]


async def test_in_a_replay_camera_and_rings_go_with_the_robot_of_then(studio: Studio) -> None:
    planter = Planter(studio.intake)
    planter.introduce()
    planter.stand(10.0)
    studio.enter("k", ROBOT, may_replay=True)
    async with await connect(studio, "k") as socket:
        picture = Picture(socket)
        await picture.look()
        await picture.until(f"/keepout/{ROBOT}/ring")
        viewer = studio.viewers["k"]
        assert viewer.client is not None
        studio.obey("k", orders.SetView(View.SIDE))
        studio.obey("k", orders.Replay(52.0, 5.001, 0.0, {"slew": 2.0}, height_m=7.0))
        owner = str(viewer.client.client_id)
        for frame in (f"/machine/{ROBOT}", f"/keepout/{ROBOT}", f"/reach/{ROBOT}"):
            shown = await picture.until(f"{owner}:{frame}", lambda node: "position" in node)
            assert shown["position"] == pytest.approx((68.6, 0.0, 7.0), abs=0.5)
        studio.obey("k", orders.SetView(View.TOP))
        assert viewer.client.camera.look_at[0] == pytest.approx(68.6, abs=0.5)
        studio.tick()
        stood = viewer.client.camera.position[0]
        studio.obey("k", orders.Replay(52.0, 5.0011, 0.0, {}))
        studio.tick()
        assert viewer.client.camera.position[0] - stood == pytest.approx(6.86, abs=0.1), "it follows what is replayed"
        studio.obey("k", orders.Live())
        studio.tick()
        assert viewer.client.camera.position[0] == pytest.approx(10.0, abs=2.0)


async def test_a_replay_hides_what_is_known_of_now_only_also_after_a_reconnect(studio: Studio) -> None:
    planter = Planter(studio.intake)
    planter.introduce()
    planter.stand(0.0)
    ended = [Target(id=f"t{i}", x_m=i, y_m=1.0, status="done") for i in range(3)]
    planter.say(Up.WORKSITE, Worksite, stop=1, targets=ended, obstacles=[])
    studio.enter("k", ROBOT, may_replay=True)
    past = orders.Replay(52.0, 5.001, 0.5, {}, undone=["t2", "strange"])
    for round_ in range(2):
        async with await connect(studio, "k") as socket:
            picture = Picture(socket)
            await picture.look()
            async with asyncio.timeout(5):
                while (client := studio.viewers["k"].client) is None:  # noqa: ASYNC110 - viser's thread hands over
                    await asyncio.sleep(0.01)
            await picture.until(f"/trees/{ROBOT}/done")
            if round_ == 0:
                studio.obey("k", past)
            for frame in ("/scan", "/labels", "/planned", f"/trees/{ROBOT}/now"):
                node = await picture.until(f"{client.client_id}:{frame}")
                assert node["visible"] is False
            await picture.until(f"{client.client_id}:/trees/{ROBOT}/done", lambda node: "props" in node)
            own = client.scene.get_handle_by_name(f"/trees/{ROBOT}/done")
            assert len(own.batched_positions) == 2, "t2 came later"  # type: ignore[union-attr]
            await picture.until(f"{client.client_id}:/machine/{ROBOT}", lambda node: "position" in node)
        async with asyncio.timeout(5):
            while studio.viewers["k"].client is not None:  # noqa: ASYNC110 - viser's thread hands over
                await asyncio.sleep(0.01)


async def test_a_reconnected_picture_gets_its_layers_back(studio: Studio) -> None:
    planter = Planter(studio.intake)
    planter.introduce()
    planter.stand(1.0)
    studio.enter("k", ROBOT, may_replay=False)
    studio.obey("k", orders.SetLayer(Group.TREES, False))
    for _ in range(2):
        async with await connect(studio, "k") as socket:
            picture = Picture(socket)
            await picture.look()
            async with asyncio.timeout(5):
                while (client := studio.viewers["k"].client) is None:  # noqa: ASYNC110 - viser's thread hands over
                    await asyncio.sleep(0.01)
            await picture.until(f"{client.client_id}:/trees")
        async with asyncio.timeout(5):
            while studio.viewers["k"].client is not None:  # noqa: ASYNC110 - viser's thread hands over
                await asyncio.sleep(0.01)


def past_of(studio: Studio, key: str = "k") -> tuple[bool, int | None]:
    """Return whether a page is told that its picture shows the record, and which moment of it."""
    said = status_of(studio, studio.viewers[key], 0.0)
    return said["is_past"], said["past_ms"]


async def test_a_replay_waits_for_its_robot_to_be_drawn_and_is_called_one_only_then(studio: Studio) -> None:
    planter = Planter(studio.intake)
    box = studio.enter("k", ROBOT, may_replay=True)
    studio.obey("k", orders.Replay(52.0, 5.001, 0.0, {"slew": 2.0}, at_ms=1000))
    studio.tick()
    assert past_of(studio) == (False, None)
    planter.introduce()
    planter.stand(1.0)
    studio.tick()
    assert past_of(studio) == (True, 1000)
    studio.world.remove(ROBOT)  # as when nobody looked for long
    studio.tick()
    past = studio.viewers["k"].past
    assert past is not None
    assert past.basis.drawn is studio.world.solid(ROBOT), "it is that of the robot drawn anew"
    while not box.empty():
        box.get_nowait()
    studio.obey("k", orders.Live())
    assert past_of(studio) == (False, None)
    assert box.get_nowait()["is_past"] is False, "a page need not wait for the next status"
    studio.tick()
    assert past_of(studio) == (False, None)


async def test_a_replay_shows_nothing_of_the_other_robots_and_no_trail_to_its_viewer_alone(studio: Studio) -> None:
    planter, away = Planter(studio.intake), Planter(studio.intake, OTHER)
    for one, x_m in ((planter, 0.0), (away, 9.0)):
        one.introduce()
        one.stand(x_m)
    studio.set_farm(Farm([FarmRobot(ROBOT, "Planter 02", 6.2), FarmRobot(OTHER, "Planter 03", 6.2)]))
    studio.enter("mine", ROBOT, may_replay=True)
    studio.enter("other", OTHER, may_replay=False)
    async with await connect(studio, "mine") as one, await connect(studio, "other") as two:
        mine, other = Picture(one), Picture(two)
        await mine.look()
        await other.look()
        await mine.until(f"/keepout/{OTHER}/ring")
        await other.until(f"/keepout/{OTHER}/ring")
        studio.obey("mine", orders.Replay(52.0, 5.001, 0.0, {}, at_ms=1000))
        owner = str(studio.viewers["mine"].client.client_id)  # type: ignore[union-attr]
        for frame in (f"/machine/{OTHER}", f"/keepout/{OTHER}", f"/trees/{OTHER}", f"/reach/{OTHER}", "/trail"):
            node = await mine.until(f"{owner}:{frame}")
            assert node["visible"] is False
        tapped_at = (9.0, 0.0, 20.0), (0.0, 0.0, -1.0)
        assert said_of(studio, "mine", *tapped_at)["what"] == "ground", "what is not seen is not there"
        assert said_of(studio, "other", *tapped_at)["name"] == "Planter 03"
        studio.obey("mine", orders.Live())
        assert said_of(studio, "mine", *tapped_at)["lines"] == ["Planter", "0.00 m/s"]
        async with asyncio.timeout(10):
            while f"{owner}:/machine/{OTHER}" in mine.nodes:
                mine._take(bytes(await one.recv()))  # type: ignore[arg-type]
        assert not [name for name in other.nodes if ":" in name and not name.endswith("/ground")]


def said_of(
    studio: Studio, key: str, origin: tuple[float, float, float], direction: tuple[float, float, float]
) -> dict[str, Any]:
    """Return what a page is told of a tap."""
    return tapped(studio, studio.viewers[key], origin, direction)


async def test_a_tap_in_a_replay_tells_nothing_of_now(studio: Studio) -> None:
    planter = Planter(studio.intake)
    planter.introduce()
    planter.stand(0.0)
    studio.enter("k", ROBOT, may_replay=True)
    states = {"t1": "done", "t2": "done", "t3": "current"}
    targets = [Target(id=id_, x_m=20.0 + i, y_m=0.0, status=state) for i, (id_, state) in enumerate(states.items())]  # type: ignore[arg-type]
    planter.say(Up.WORKSITE, Worksite, stop=1, targets=targets, obstacles=[])
    studio.tick()
    studio.tick()
    studio.obey("k", orders.Replay(52.0, 5.0, 0.0, {}, undone=["t2"], at_ms=1000))
    down = (0.0, 0.0, -1.0)
    assert said_of(studio, "k", (0.0, 0.0, 20.0), down)["lines"] == ["Planter"], "no speed of now"
    names = [said_of(studio, "k", (20.0 + i, 0.0, 20.0), down)["name"] for i in range(3)]
    assert names == ["Place t1", "Ground", "Ground"]
    studio.obey("k", orders.Live())
    names = [said_of(studio, "k", (20.0 + i, 0.0, 20.0), down)["name"] for i in range(3)]
    assert names == ["Place t1", "Place t2", "Place t3"]


async def test_what_is_planted_while_somebody_replays_is_not_there_yet(tmp_path: Path) -> None:
    clock = FakeClock()
    studio = Studio(Intake(clock), tmp_path, SECRET, clock)
    try:
        studio.set_farm(Farm([FarmRobot(ROBOT, "Planter 02", 6.2)]))
        then_ms = round(clock.utc().timestamp() * 1000)
        studio.set_plan(
            ROBOT, Plan("m", treated=[Treated("t0", 0, 1, "done", then_ms + 1), Treated("t1", 1, 1, "done")])
        )
        planter = Planter(studio.intake)
        planter.introduce()
        planter.stand(0.0)
        planter.say(Up.WORKSITE, Worksite, stop=1, targets=[Target(id="t2", x_m=2, y_m=1, status="done")], obstacles=[])
        studio.enter("k", ROBOT, may_replay=True)
        for _ in range(2):
            studio.tick()
        studio.obey("k", orders.Replay(52.0, 5.0, 0.0, {}, at_ms=then_ms))
        assert undone(studio) == {"t0"}
        clock.advance(5.0)
        both = [Target(id="t2", x_m=2, y_m=1, status="done"), Target(id="t3", x_m=3, y_m=1, status="done")]
        planter.say(Up.WORKSITE, Worksite, stop=1, targets=both, obstacles=[])
        for _ in range(2):
            studio.tick()
        assert undone(studio) == {"t0", "t3"}, "the order did not know of it"
        studio.obey("k", orders.Replay(52.0, 5.0, 0.0, {}, at_ms=then_ms + 6000))
        assert undone(studio) == set()
    finally:
        await studio.stop()


def undone(studio: Studio) -> frozenset[str]:
    """Return the places that the replay of a page does not show."""
    past = studio.viewers["k"].past
    assert past is not None
    return past.undone


async def test_an_order_that_cannot_be_read_is_ignored_and_the_socket_stays(studio: Studio, tmp_path: Path) -> None:
    planter = Planter(studio.intake)
    planter.introduce()
    planter.stand(0.0)
    studio.tick()
    app = control_app(studio, ModelShelf(tmp_path), SECRET)
    headers = {SECRET_HEADER: SECRET, VIEWER_HEADER: "k", RIGHTS_HEADER: "replay"}
    async with AsgiSocket(app, f"/viewer?robot={ROBOT}", headers) as socket:
        socket.say('{"k":"replay","lat_deg":95,"lon_deg":5,"theta_rad":1}')
        socket.say('{"k":"replay","lat_deg":52,"lon_deg":5,"theta_rad":1,"at_ms":1000}')
        said = await socket.next()
        assert (socket.code, msgspec.json.decode(said.get("text", "null"))["past_ms"]) == (None, 1000)


async def test_how_far_a_touched_place_is_is_told_again_as_the_robot_moves(studio: Studio) -> None:
    planter = Planter(studio.intake)
    planter.introduce()
    planter.stand(0.0)
    studio.enter("k", ROBOT, may_replay=True)
    studio.tick()
    studio.tick()
    studio.touch("k", (20.0, 0.0, 9.0), (0.0, 0.0, -1.0))
    viewer = studio.viewers["k"]
    near = status_of(studio, viewer, 0.0)["touched"]
    assert (near["x_m"], near["distance_m"]) == (20.0, 20.0)
    planter.stand(-20.0)
    studio.tick()
    far = status_of(studio, viewer, 0.0)["touched"]
    assert (far["x_m"], far["distance_m"]) == (20.0, 40.0)
    assert far["arm_m"] == pytest.approx(near["arm_m"] + 20.0, abs=0.01)
    studio.obey("k", orders.Replay(52.0, 5.0, 0.0, {}, at_ms=1000))
    assert status_of(studio, viewer, 0.0)["touched"]["distance_m"] == 20.0, "from where it was then"
    studio.obey("k", orders.Unmark())
    assert status_of(studio, viewer, 0.0)["touched"] is None


async def test_the_age_of_the_pose_is_that_of_the_drawn_one_while_newer_ones_cannot_be_read(tmp_path: Path) -> None:
    clock = FakeClock()
    studio = Studio(Intake(clock), tmp_path, SECRET, clock)
    try:
        studio.set_farm(Farm([FarmRobot(ROBOT, "Planter 02", 6.2)]))
        planter = Planter(studio.intake)
        planter.introduce()
        planter.stand(3.0)
        studio.enter("k", ROBOT, may_replay=False)
        studio.tick()
        for kind in (Up.TELEMETRY, Up.FACTSHEET):
            clock.advance(5.0)
            studio.intake.take(topic(ROBOT, kind), b'{"lat_deg": null}', False)
            studio.tick()
        said = status_of(studio, studio.viewers["k"], clock.mono_s())
        assert (said["is_drawn"], said["pose_age_s"]) == (True, 10.0)
        planter.rest(10.0)
        planter.stand(4.0)
        studio.tick()
        said = status_of(studio, studio.viewers["k"], clock.mono_s())
        assert (said["is_drawn"], said["pose_age_s"]) == (True, 0.0), "it is drawn by what its factsheet said before"
        assert studio.world.mover.place(f"/machine/{ROBOT}").xyz[0] == 4.0
    finally:
        await studio.stop()


async def test_robots_that_are_not_registered_are_not_drawn(studio: Studio) -> None:
    planter = Planter(studio.intake)
    planter.introduce()
    planter.stand(1.0)
    studio.set_farm(Farm([]))
    studio.tick()
    assert studio.world.robots() == []
