"""The STOP process: socket, server, signals, and the note that says where it listens."""

from __future__ import annotations

import asyncio
import contextlib
import errno
import gc
import logging
import os
import signal
import socket
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import msgspec
import uvicorn

from hmi.clock import SystemClock
from hmi.settings import Settings
from hmi.stop_gateway.application import make_app
from hmi.stop_gateway.errors import PortTaken
from hmi.stop_gateway.frames import MAX_FRAME_BYTES
from hmi.stop_gateway.gateway import Gateway
from hmi.stop_gateway.outbox import write_whole

SWITCH_S = 0.0005  # a network thread gives way to the loop ten times sooner than Python's usual 5 ms
PRIORITY = -10  # above console, simulator and browser; it uses next to nothing of it
GRACE_S = 1  # requests under way at the end; browsers are sent away before
_log = logging.getLogger("headland.stop")


class StopServer(uvicorn.Server):
    """uvicorn that sends the browsers away first, so that ending never waits for them."""

    def __init__(self, config: uvicorn.Config, gateway: Gateway, on_listening: Callable[[], None]) -> None:
        super().__init__(config)
        self._gateway = gateway
        self._on_listening = on_listening

    @contextlib.contextmanager
    def capture_signals(self) -> Iterator[None]:
        """End on SIGTERM and SIGINT with exit code 0, instead of dying of the signal after the clean-up."""
        loop = asyncio.get_running_loop()
        with contextlib.suppress(RuntimeError, ValueError, NotImplementedError):  # not the main thread: no signals
            for number in (signal.SIGTERM, signal.SIGINT):
                loop.add_signal_handler(number, self.handle_exit, number, None)
        yield

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        """Start, then say so."""
        await super().startup(sockets)
        if self.started:
            gc.collect()
            gc.freeze()  # what was loaded at start is never garbage: shorter pauses on the STOP path
            self._on_listening()

    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        """Send the browsers away, then end."""
        self._gateway.hub.close()
        await super().shutdown(sockets)


def run_gateway(settings: Settings, *, port: int | None = None, on_ready: Callable[[str], None] | None = None) -> None:
    """Serve STOP until SIGTERM or SIGINT.

    ``HEADLAND_DATA/run/stop.json`` says pid, port and address from the moment it listens. With port 0 the
    port of the last run is taken again if it is free, so that browsers find a restarted gateway.

    Args:
        settings: of the installation.
        port: instead of ``settings.stop_port``.
        on_ready: called with the gateway's address when it listens.

    Raises:
        PortTaken: another program has the port.
    """
    _go_first()
    note = settings.data / "run" / "stop.json"
    listener = _listen(settings.host, settings.stop_port if port is None else port, _last_port(note))
    bound: int = listener.getsockname()[1]
    url = _address(settings, bound)

    def listening() -> None:
        try:
            write_whole(note, msgspec.json.encode({"pid": os.getpid(), "port": bound, "url": url}))
        except OSError as error:  # a full disk must not end STOP: browsers know the address from their last page
            _log.error("%s cannot be written: %s", note, error)
        _log.info("STOP gateway listens at %s", url)
        if on_ready is not None:
            on_ready(url)

    async def serve() -> None:
        gateway = Gateway(settings, SystemClock())
        config = _config(settings, gateway)
        await StopServer(config, gateway, listening).serve(sockets=[listener])

    with contextlib.suppress(KeyboardInterrupt), contextlib.closing(listener), _runner() as runner:
        runner.run(serve())


def _go_first() -> None:
    """Let nothing else on the machine come before STOP, as far as this user may ask for that."""
    sys.setswitchinterval(SWITCH_S)
    with contextlib.suppress(OSError, AttributeError):  # only root may; without it STOP is an equal among others
        os.setpriority(os.PRIO_PROCESS, 0, PRIORITY)


def _runner() -> asyncio.Runner:
    try:
        import uvloop
    except ImportError:  # not made for this platform: the loop of the standard library does it too
        return asyncio.Runner()
    return asyncio.Runner(loop_factory=uvloop.new_event_loop)


def _config(settings: Settings, gateway: Gateway) -> uvicorn.Config:
    return uvicorn.Config(
        make_app(gateway, settings),
        ws="websockets-sansio",
        ws_per_message_deflate=False,
        ws_max_size=MAX_FRAME_BYTES,
        ws_ping_interval=5.0,
        ws_ping_timeout=5.0,
        lifespan="on",
        log_config=None,
        access_log=False,
        proxy_headers=False,
        server_header=False,
        timeout_graceful_shutdown=GRACE_S,
        ssl_certfile=settings.tls_cert,
        ssl_keyfile=settings.tls_key,
    )


def _listen(host: str, port: int, last_port: int | None) -> socket.socket:
    for choice in [last_port, port] if port == 0 and last_port else [port]:
        try:
            return _bind(host, choice)
        except OSError as error:
            if error.errno != errno.EADDRINUSE:
                raise
    raise PortTaken(f"Port {port} is taken by another program; set HEADLAND_STOP_PORT to a free one, or to 0.")


def _bind(host: str, port: int) -> socket.socket:
    listener = socket.socket(socket.AF_INET6 if ":" in host else socket.AF_INET, socket.SOCK_STREAM)
    try:
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        listener.bind((host, port))
        listener.listen(128)
    except OSError:
        listener.close()
        raise
    return listener


def _last_port(note: Path) -> int | None:
    try:
        port = msgspec.json.decode(note.read_bytes())["port"]
    except (OSError, msgspec.DecodeError, KeyError, TypeError):
        return None
    return port if isinstance(port, int) and 0 < port < 65536 else None


def _address(settings: Settings, port: int) -> str:
    if settings.stop_public_url:
        return settings.stop_public_url
    host = {"0.0.0.0": "127.0.0.1", "::": "[::1]"}.get(settings.host, settings.host)  # noqa: S104 - compared only
    return f"{'https' if settings.is_tls else 'http'}://{host}:{port}"
