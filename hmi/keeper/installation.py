"""The two installations: a demo with simulated robots, and real robots."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from pathlib import Path

from hmi.cameras import door as camera_door
from hmi.demo.cloud_services import FORECAST_PATH, PLANNER_PATH
from hmi.keeper.broker import answers, demo_broker
from hmi.keeper.data_folder import keep_secret, require_writable
from hmi.keeper.errors import StartError
from hmi.keeper.keeper import Keeper
from hmi.keeper.part import PartSpec
from hmi.keeper.ports import free_port, require_free
from hmi.media import door as media_door
from hmi.settings import Settings

OnReady = Callable[[str], None]


def run_demo(on_ready: OnReady, *, is_tls: bool = False) -> None:
    """Run broker, simulator, STOP gateway and console until told to end.

    Raises:
        StartError: a busy port, an unwritable data folder or a part that does not start.
    """
    from hmi.demo.fleet import write_demo_fleet

    folder = Path(os.environ.get("HEADLAND_DATA", "data"))
    data = require_writable(folder)
    if is_tls:
        _use_certificate(data)
    os.environ |= {
        "HEADLAND_DEMO": "true",
        "HEADLAND_DATA": str(data),
        "HEADLAND_SECRET": keep_secret(data / "run" / "demo-secret"),
        "HEADLAND_BROKER_URL": f"mqtt://127.0.0.1:{free_port()}",
        "HEADLAND_STOP_PORT": str(free_port()),
    }
    _point_to_demo_cloud()
    settings = Settings()  # type: ignore[call-arg]  # every field comes from file or variables
    require_free(settings.host, settings.port, "HEADLAND_PORT")
    broker_port = int(settings.broker_url.rsplit(":", 1)[1])
    simulator_port = free_port()
    robots = write_demo_fleet(data, f"http://127.0.0.1:{simulator_port}", settings.demo_fleet)
    simulator = PartSpec(
        "simulator",
        (sys.executable, "-m", "hmi", "simulate", "fleet", "--broker", settings.broker_url, "--robots", str(robots),
         "--port", str(simulator_port), "--state", str(data / "simulator"), "--sensors", *_cloud_of_robots(settings),
         *(("--always-day",) if settings.demo_light == "day" else ()),
         *(("--cameras-ready",) if settings.cameras else ())),
        is_ready=lambda: answers("127.0.0.1", simulator_port),
        url=f"http://127.0.0.1:{simulator_port}",
        dies_with_keeper=True,
        after=("broker", "stop"),  # the console takes longest to start: it shall not share its core with everybody
    )  # fmt: skip
    parts = [demo_broker(data, broker_port), _console(settings), _stop(settings, after=("broker",)), simulator]
    Keeper(parts, data, _later(settings)).run(lambda: on_ready(_url(settings)))


def run_serve(on_ready: OnReady, *, is_tls: bool = False) -> None:
    """Run STOP gateway and console for real robots until told to end.

    Raises:
        StartError: a busy port, an unwritable data folder or a part that does not start.
    """
    settings = Settings()  # type: ignore[call-arg]  # every field comes from file or variables
    if is_tls and not settings.is_tls:
        _use_certificate(settings.data)
        settings = Settings()  # type: ignore[call-arg]  # now with the certificate
    if settings.demo:
        raise StartError("HEADLAND_DEMO is set: use `headland demo` for simulated robots, or unset it.")
    data = require_writable(settings.data)
    if settings.stop_port == 0:
        raise StartError("Set HEADLAND_STOP_PORT: tablets keep the address of the STOP gateway.")
    require_free(settings.host, settings.port, "HEADLAND_PORT")
    require_free(settings.host, settings.stop_port, "HEADLAND_STOP_PORT")
    os.environ["HEADLAND_DATA"] = str(data)
    # STOP first: whatever else fails to start, it is there
    parts = [_stop(settings), _console(settings, after=("stop",))]
    Keeper(parts, data, _later(settings)).run(lambda: on_ready(_url(settings)))


def _use_certificate(data: Path) -> None:
    """Let every part speak HTTPS with what `headland cert` left in the data folder."""
    from hmi.keeper.certificates import made_certificates

    made = made_certificates(data / "tls")
    os.environ |= {"HEADLAND_TLS_CERT": str(made.cert), "HEADLAND_TLS_KEY": str(made.key)}


def _stop(settings: Settings, after: tuple[str, ...] = ()) -> PartSpec:
    return PartSpec(
        "stop",
        (sys.executable, "-m", "hmi.stop_gateway"),
        is_ready=lambda: answers(settings.near_host, settings.stop_port),
        url=settings.stop_public_url or _address(settings, settings.stop_port),
        dies_with_keeper=settings.demo,
        after=after,
    )


def _console(settings: Settings, after: tuple[str, ...] = ()) -> PartSpec:
    return PartSpec(
        "console",
        (sys.executable, "-m", "hmi.app"),
        is_ready=lambda: answers(settings.near_host, settings.port),
        url=_url(settings),
        dies_with_keeper=settings.demo,
        after=after,
    )


def _later(settings: Settings) -> list[PartSpec]:
    has_cloud = settings.demo and settings.demo_cloud and settings.cloud_url
    return [
        *([_media(settings)] if settings.media else []),
        *([_cameras(settings)] if settings.cameras else []),
        *([_demo_cloud(settings)] if has_cloud else []),
    ]


def _point_to_demo_cloud() -> None:
    """Let the console of a demo speak to the simulated context broker, unless it has a cloud of its own."""
    settings = Settings()  # type: ignore[call-arg]  # every field comes from file or variables
    if settings.cloud_url:
        os.environ["HEADLAND_DEMO_CLOUD"] = "false"
    elif settings.demo_cloud:
        os.environ |= {"HEADLAND_CLOUD_URL": f"http://127.0.0.1:{free_port()}", "HEADLAND_CLOUD_TENANT": "demo"}
        cloud_url = os.environ["HEADLAND_CLOUD_URL"]
        if not settings.forecast_url:
            os.environ["HEADLAND_FORECAST_URL"] = cloud_url + FORECAST_PATH
        if settings.demo_planner and not settings.planner_url:
            os.environ["HEADLAND_PLANNER_URL"] = cloud_url + PLANNER_PATH
        if not settings.is_tls:  # the simulated broker does not know a certificate made here
            os.environ["HEADLAND_CLOUD_NOTIFY_URL"] = f"http://127.0.0.1:{settings.port}"


def _cloud_of_robots(settings: Settings) -> tuple[str, ...]:
    if not settings.demo_cloud or not settings.cloud_url:
        return ()
    return ("--cloud", settings.cloud_url, "--cloud-tenant", settings.cloud_tenant, "--farm", settings.farm_id)


def _demo_cloud(settings: Settings) -> PartSpec:
    url = settings.cloud_url or ""
    port = int(url.rsplit(":", 1)[1])
    return PartSpec(
        "context_broker",
        (sys.executable, "-m", "hmi", "simulate", "context-broker", "--port", str(port),
         *_beside_the_cloud(settings, url)),
        is_ready=lambda: answers("127.0.0.1", port),
        url=url,
        dies_with_keeper=True,
    )  # fmt: skip


def _beside_the_cloud(settings: Settings, url: str) -> list[str]:
    """Return the services that the demo's cloud serves in its own process: no further one starts for them."""
    served = {"--forecast": settings.forecast_url == url + FORECAST_PATH,
              "--planner": settings.planner_url == url + PLANNER_PATH}  # fmt: skip
    return [name for name, is_served in served.items() if is_served]


def _media(settings: Settings) -> PartSpec:
    def is_ready() -> bool:
        note = media_door.read_note(settings.data)
        return note is not None and answers("127.0.0.1", note.control_port)

    return PartSpec("media", (sys.executable, "-m", "hmi.media"), is_ready=is_ready, dies_with_keeper=settings.demo)


def _cameras(settings: Settings) -> PartSpec:
    def is_ready() -> bool:
        note = camera_door.read_note(settings.data)
        return note is not None and answers("127.0.0.1", note.control_port)

    return PartSpec("cameras", (sys.executable, "-m", "hmi.cameras"), is_ready=is_ready, dies_with_keeper=settings.demo)


def _url(settings: Settings) -> str:
    return _address(settings, settings.port)


def _address(settings: Settings, port: int) -> str:
    host = settings.near_host
    return f"{'https' if settings.is_tls else 'http'}://{f'[{host}]' if ':' in host else host}:{port}"
