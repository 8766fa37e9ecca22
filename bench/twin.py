"""The twin's cost: 50 robots with joints at 10 Hz into one picture, beside viser's own way of moving a URDF.

Prints ``twin_50x10_cpu_pct`` (percent of one core of the process that draws, viser's threads and one connected viewer
included) and ``twin_naive_ratio``: the same machine moved by ``ViserUrdf.update_cfg`` in the same run, CPU by CPU. The
naive way is slower than real time, so both count CPU for one round and not what a core happens to manage; it is done
with a few robots and counted up, which flatters it.
"""

from __future__ import annotations

import asyncio
import math
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import viser
import websockets.asyncio.client
from viser.extras import ViserUrdf
from websockets.typing import Subprotocol

from bench.twin_viewer import CAMERA, drain
from hmi.twin.guarded_viser import guarded_viser
from hmi.twin.kinematics import Place
from hmi.twin.library import OWN, own_model
from hmi.twin.machine import Form
from hmi.twin.mesh_files import MeshFolder
from hmi.twin.posture import Posture
from hmi.twin.rotation import yaw
from hmi.twin.skin import skin_of
from hmi.twin.world import World

ROBOTS, RATE_HZ = 50, 10
NAIVE_ROBOTS = 5
ROUNDS, NAIVE_ROUNDS = 100, 20
CONDITIONS = "50 planters of 8 moving joints, body and every joint moving each round, one viewer connected, CPU time"
LIMITS = {"slew": 1.5, "boom": 0.6, "stick": -1.2, "telescope": 1.0, "rotator": 1.0}


def run() -> Iterator[dict[str, Any]]:
    """Yield both figures."""
    ours_s, naive_s = asyncio.run(_measure())
    pct, naive_pct = 100 * ours_s * RATE_HZ, 100 * naive_s * RATE_HZ
    yield _figure("twin_50x10_cpu_pct", round(pct, 1), "%", round(naive_pct, 1), naive_pct / pct)
    yield _figure("twin_naive_ratio", round(naive_pct / pct, 1), "x", None, None)


def _figure(name: str, value: float, unit: str, naive: float | None, ratio: float | None) -> dict[str, Any]:
    shown = None if ratio is None else round(ratio, 1)
    return {"name": name, "value": value, "unit": unit, "naive": naive, "ratio": shown, "conditions": CONDITIONS}


async def _measure() -> tuple[float, float]:
    """Return CPU seconds for one round of all robots, our way and the naive one."""
    server = guarded_viser(lambda _headers: True)
    async with websockets.asyncio.client.connect(
        f"ws://127.0.0.1:{server.get_port()}/",
        subprotocols=[Subprotocol("viser-v1.1.1")],
        compression=None,
        max_size=None,
        proxy=None,
    ) as socket:
        await socket.send(CAMERA)
        reader = asyncio.create_task(drain(socket))
        ours = await _round_s(_ours(server), ROUNDS)
        naive = await _round_s(_naive(server), NAIVE_ROUNDS) * ROBOTS / NAIVE_ROBOTS
        reader.cancel()
        await asyncio.gather(reader, return_exceptions=True)
    server.stop()
    return ours, naive


def _ours(server: viser.ViserServer) -> Callable[[int], None]:
    model = own_model("planter")
    form = Form.of(model, skin_of(model, MeshFolder(OWN).read))
    world = World(server)

    def move(number: int) -> None:
        with world.at_once():
            for robot in range(ROBOTS):
                x_m, turn, joints = _where(robot, number)
                posture = Posture(Place((x_m, 8.0 * robot, 0.0), yaw(turn)), joints)
                world.show(f"robot-{robot}", form, posture, 0.1 * number, has_ghost=False)

    return move


def _naive(server: viser.ViserServer) -> Callable[[int], None]:
    bodies = [server.scene.add_frame(f"/naive/{robot}", show_axes=False) for robot in range(NAIVE_ROBOTS)]
    with tempfile.TemporaryDirectory() as folder:  # the loader wants names of its own
        path = Path(folder) / "planter.urdf"
        path.write_bytes((OWN / "planter.urdf").read_bytes())
        models = [ViserUrdf(server, path, root_node_name=f"/naive/{robot}") for robot in range(NAIVE_ROBOTS)]
    names = models[0].get_actuated_joint_names()

    def move(number: int) -> None:
        for robot, (body, model) in enumerate(zip(bodies, models, strict=True)):
            x_m, turn, joints = _where(robot, number)
            body.position, body.wxyz = (x_m, 8.0 * robot, 0.0), np.asarray(yaw(turn))
            model.update_cfg(np.asarray([joints.get(name, 0.0) for name in names]))

    return move


def _where(robot: int, number: int) -> tuple[float, float, dict[str, float]]:
    phase = 0.1 * number + robot
    return 0.05 * number, 0.02 * number, {name: most * math.sin(phase) for name, most in LIMITS.items()}


async def _round_s(move: Callable[[int], None], rounds: int) -> float:
    """Return CPU seconds of one round, sending included; the first builds the scene and does not count."""
    move(0)
    await asyncio.sleep(3.0)
    began_s = time.process_time()
    for number in range(1, rounds + 1):
        move(number)
        await asyncio.sleep(0.05)  # viser's thread sends
    return (time.process_time() - began_s) / rounds
