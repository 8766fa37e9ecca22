"""The simulator process: world, broker sessions and robot HTTP on one event loop."""

from __future__ import annotations

import asyncio
import contextlib
import importlib
import itertools
import logging
import secrets
import signal
import socket
import threading
import time
from collections.abc import Callable, Iterator

import structlog
import uvicorn
from starlette.routing import Route

from backend_clients.edge import messages_up as up
from backend_clients.simulator import tester_http
from backend_clients.simulator.cameras.web import camera_web
from backend_clients.simulator.config import CloudConfig, SimulatorConfig
from backend_clients.simulator.director import Director
from backend_clients.simulator.edge_session import TICK_S, EdgeSession
from backend_clients.simulator.enu import EnuFrame
from backend_clients.simulator.farm_ways import FarmWays
from backend_clients.simulator.foreman import Foreman
from backend_clients.simulator.http_server import RobotEndpoint, application
from backend_clients.simulator.late_sensors import LateSensors
from backend_clients.simulator.links import LinkMaker, SharedLink, own_links
from backend_clients.simulator.loop_mail import LoopMail
from backend_clients.simulator.traffic import Traffic
from backend_clients.simulator.world import LEAN_TICKS, World
from hmi.clock import Clock, SystemClock

MAX_CATCH_UP_S = 0.25  # after a longer freeze the world does not jump to make up for it
LEAN_PER_LINK = 250
WAYS_LATER_S = 25.0  # whoever sends a robot home before waits a second for its way
AGENTS_LATER_S = 6.0  # a little after the demo's broker, which starts when everything else serves
LINK_STOP_S = 0.6  # together with HTTP this keeps the promise of ending within one second
OnReady = Callable[[int], None]
OnAck = Callable[[str, up.Ack], None]

log = structlog.get_logger(__name__)


class Simulator:
    """Owns the world, one session a robot, and the HTTP server; ``run`` ends when ``stop`` was called.

    Args:
        config: robots, addresses, seed.
        clock: the system's unless a test brings its own.
        on_ready: called once with the HTTP port when everything listens.
    """

    def __init__(self, config: SimulatorConfig, *, clock: Clock | None = None, on_ready: OnReady | None = None) -> None:
        self._config, self._on_ready = config, on_ready
        self._clock = clock or SystemClock()
        self._stopping: asyncio.Event | None = None
        self._loop: asyncio.AbstractEventLoop | None = None

    def stop(self) -> None:
        """Ask for the end; safe from any thread and from signal handlers."""
        if self._loop is not None and self._stopping is not None and not self._loop.is_closed():
            self._loop.call_soon_threadsafe(self._stopping.set)

    async def run(self) -> None:
        """Simulate until asked to stop.

        Raises:
            OSError: the HTTP port is taken.
        """
        config = self._config
        self._loop, self._stopping = asyncio.get_running_loop(), asyncio.Event()
        listener = _listen(config.host, config.port)
        ways = FarmWays(config.features) if config.features else None
        world = World(
            config.robots, self._clock, seed=config.seed, speed=config.speed, state_dir=config.state_dir, ways=ways
        )
        traffic = Traffic(world.robots.values(), self._clock, seed=config.seed)
        foreman = Foreman(world.robots, config.jobs, self._clock, seed=config.seed)
        players = frozenset(config.jobs) if config.opening is not None else frozenset()
        director = Director(world.robots, self._clock, players=players, opening=config.opening, seed=config.seed)
        links, mail = _links(config), LoopMail(self._loop)
        sessions = {
            robot_id: EdgeSession(robot, links[robot_id], self._loop, mail) for robot_id, robot in world.robots.items()
        }

        def on_ack(robot_id: str, ack: up.Ack) -> None:
            sessions[robot_id].answer(ack)

        endpoint = RobotEndpoint(world, on_ack, camera_web(world, config.features, is_always_day=config.is_always_day))
        sensors = LateSensors(config, self._clock)
        server = _Server(_server_config(endpoint, tester_http.routes(world, director, sensors)))
        serving = asyncio.create_task(server.serve(sockets=[listener]), name="simulator-http")
        living = asyncio.create_task(
            self._live(world, (foreman, director, traffic), list(sessions.values())), name="simulator-world"
        )
        aside = [asyncio.create_task(sensors.run(), name="simulator-sensors")]
        if config.are_cameras_ready:
            preparing = endpoint.cameras.prepare(world.robots.values())
            aside.append(asyncio.create_task(preparing, name="simulator-cameras"))
        if ways is not None:
            aside.append(asyncio.create_task(_look_around(ways, config), name="simulator-ways"))
        if config.cloud is not None:
            running = _run_agents(config.cloud, world, self._clock, on_ack)
            aside.append(asyncio.create_task(running, name="simulator-cloud"))
        stopping = asyncio.create_task(self._stopping.wait(), name="simulator-stop")
        try:
            if self._on_ready is not None:
                self._on_ready(listener.getsockname()[1])
            await asyncio.wait({serving, living, stopping}, return_when=asyncio.FIRST_COMPLETED)
        finally:
            endpoint.close()
            stopping.cancel()
            living.cancel()
            server.should_exit = server.force_exit = True
            _save(world)
            _stop_links(list(sessions.values()))
            for task in aside:
                task.cancel()
            await asyncio.gather(*aside, return_exceptions=True)
            results = await asyncio.gather(serving, living, endpoint.cameras.ended(), return_exceptions=True)
        for result in results:
            if isinstance(result, Exception):
                raise result

    async def _live(self, world: World, people: tuple[Foreman, Director, Traffic], sessions: list[EdgeSession]) -> None:
        """Step the world and its sessions at 20 Hz; lean sessions have their turn twice a second."""
        if not sessions:
            await asyncio.Event().wait()  # field sensors alone: there is nothing to step
        before = due = self._clock.mono_s()
        turns = [[one for n, one in enumerate(sessions) if _has_turn(one, n, k)] for k in range(LEAN_TICKS)]
        for turn in itertools.cycle(turns):
            now = self._clock.mono_s()
            world.step(min(now - before, MAX_CATCH_UP_S))
            for somebody in people:
                somebody.look()
            before = now
            for session in turn:
                session.tick()
            due = max(due + TICK_S, self._clock.mono_s())
            await asyncio.sleep(max(due - self._clock.mono_s(), 0.001))


def run_simulator(config: SimulatorConfig, *, on_ready: OnReady | None = None) -> None:
    """Run until SIGTERM or SIGINT; returns within a second of it.

    Raises:
        OSError: the HTTP port is taken, or the state folder cannot be written.
    """
    structlog.configure(wrapper_class=structlog.make_filtering_bound_logger(logging.INFO))  # not each call to the cloud
    simulator = Simulator(config, on_ready=on_ready)

    async def main() -> None:
        loop = asyncio.get_running_loop()
        for number in (signal.SIGTERM, signal.SIGINT):
            loop.add_signal_handler(number, simulator.stop)
        await simulator.run()

    asyncio.run(main())


async def _run_agents(cloud: CloudConfig, world: World, clock: Clock, on_ack: OnAck) -> None:
    """Begin some seconds after everything else: who waits for the demo to start does not wait for this."""
    await asyncio.sleep(AGENTS_LATER_S)
    agent = await asyncio.to_thread(importlib.import_module, "backend_clients.simulator.cloud_agent")
    await agent.agents_of(cloud, dict(world.robots), clock, on_ack).run()


async def _look_around(ways: FarmWays, config: SimulatorConfig) -> None:
    """Learn the farm's ways beside the world, when everything else has started."""
    await asyncio.sleep(WAYS_LATER_S)
    for lat_deg, lon_deg in {(one.datum_lat_deg, one.datum_lon_deg) for one in config.robots if not one.is_lean}:
        await asyncio.to_thread(ways.prepare, EnuFrame(lat_deg, lon_deg))


def _has_turn(session: EdgeSession, number: int, turn: int) -> bool:
    return not session.is_lean or number % LEAN_TICKS == turn


def _links(config: SimulatorConfig) -> dict[str, LinkMaker]:
    """Return who makes each robot's link: lean robots share a few connections."""
    own = own_links(config.broker_url)
    links = {robot.id: own for robot in config.robots}
    lean = [robot.id for robot in config.robots if robot.is_lean]
    for number, first in enumerate(range(0, len(lean), LEAN_PER_LINK)):
        ids = lean[first : first + LEAN_PER_LINK]
        shared = SharedLink(config.broker_url, f"lean-{number}-{secrets.token_hex(4)}", ids)
        links |= dict.fromkeys(ids, shared.make)
    return links


class _Server(uvicorn.Server):
    """uvicorn without its own signal handling; this process has one owner of signals."""

    @contextlib.contextmanager
    def capture_signals(self) -> Iterator[None]:
        yield


def _server_config(endpoint: RobotEndpoint, testers: list[Route]) -> uvicorn.Config:
    return uvicorn.Config(
        application(endpoint, testers),
        log_config=None,
        log_level="critical",  # it shouts about requests a silence fault holds at the end
        access_log=False,
        lifespan="off",
        timeout_graceful_shutdown=0,
        server_header=False,
    )


def _listen(host: str, port: int) -> socket.socket:
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    listener = socket.socket(family, socket.SOCK_STREAM)
    listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        listener.bind((host, port))
        listener.listen()  # from here on who calls is kept waiting, not refused, until the server takes the call
    except OSError:
        listener.close()
        raise
    return listener


def _save(world: World) -> None:
    for robot in world.robots.values():
        if robot.boot is not None:
            robot.boot.brain.save()


def _close_each(sessions: list[EdgeSession]) -> None:
    for session in sessions:
        session.close()


def _stop_links(sessions: list[EdgeSession]) -> None:
    # paho may sit in a connect for seconds; daemon threads let the process end all the same
    shared = [session for session in sessions if session.is_lean]
    work: list[Callable[[], None]] = [session.close for session in sessions if not session.is_lean]
    work.append(lambda: _close_each(shared))
    closers = [threading.Thread(target=one, daemon=True) for one in work]
    for closer in closers:
        closer.start()
    until = time.monotonic() + LINK_STOP_S
    for closer in closers:
        closer.join(max(until - time.monotonic(), 0.0))
