"""``headland demo``, ``serve``, ``console``, ``stop``, ``media``, ``cameras``: the installation and its processes."""

from __future__ import annotations

from typing import Annotated

import typer

Tls = Annotated[bool, typer.Option("--tls", help="Speak HTTPS with the certificate of `headland cert`.")]


def register(app: typer.Typer) -> None:
    """Add the commands to ``app``."""
    app.command()(demo)
    app.command()(serve)
    app.command()(console)
    app.command()(stop)
    app.command()(media)
    app.command()(cameras)


def demo(*, tls: Tls = False) -> None:
    """Start everything with simulated robots: broker, STOP gateway, console, simulator."""
    from hmi.keeper.installation import run_demo

    run_demo(lambda url: typer.echo(f"Headland is ready at {url}"), is_tls=tls)


def serve(*, tls: Tls = False) -> None:
    """Start console and STOP gateway for real robots and keep them running."""
    from hmi.keeper.installation import run_serve

    run_serve(lambda url: typer.echo(f"Headland is ready at {url}"), is_tls=tls)


def console() -> None:
    """Run the console process alone (the keeper does this)."""
    from hmi.app import run_console
    from hmi.settings import Settings

    run_console(Settings())  # type: ignore[call-arg]  # every field comes from file or variables


def stop() -> None:
    """Run the STOP gateway process alone (the keeper does this)."""
    from hmi.settings import Settings
    from hmi.stop_gateway.process import run_gateway

    run_gateway(Settings())  # type: ignore[call-arg]  # every field comes from file or variables


def media() -> None:
    """Run the media process with the 3D twin alone (the keeper does this)."""
    from hmi.media.process import run_media
    from hmi.settings import Settings

    run_media(Settings())  # type: ignore[call-arg]  # every field comes from file or variables


def cameras() -> None:
    """Run the camera process alone (the keeper does this)."""
    from hmi.cameras.process import run_cameras
    from hmi.settings import Settings

    run_cameras(Settings())  # type: ignore[call-arg]  # every field comes from file or variables
