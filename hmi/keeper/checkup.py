"""What ``headland check`` looks at; each finding says what to do."""

from __future__ import annotations

import secrets
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from datetime import UTC, datetime
from importlib import metadata

from pydantic import ValidationError

from backend_clients.edge.mqtt import BrokerUrl
from hmi.keeper.broker import answers, find_mosquitto
from hmi.keeper.data_folder import read_json, require_writable
from hmi.keeper.errors import StartError
from hmi.keeper.ports import require_free
from hmi.settings import Settings

EARLIEST_HONEST_YEAR = 2026  # before this the clock was never set


@dataclass(frozen=True, slots=True)
class Finding:
    """One thing looked at; ``text`` says what was found or what to do."""

    subject: str
    is_ok: bool
    text: str


def checkup() -> list[Finding]:
    """Return findings for this machine and its settings; starts nothing, changes nothing."""
    findings = [_python(), *_packages(), _clock()]
    try:
        settings = Settings()  # type: ignore[call-arg]  # every field comes from file or variables
    except ValidationError as error:
        text = "; ".join(problem["msg"].removeprefix("Value error, ") for problem in error.errors())
        fresh = secrets.token_urlsafe(48)
        return [*findings, Finding("settings", False, f"{text}. A fresh secret: HEADLAND_SECRET={fresh}")]
    findings.append(Finding("settings", True, "read and consistent"))
    findings.append(_tried("data folder", lambda: f"{require_writable(settings.data)} can be written"))
    findings += [_broker(settings), *_ports(settings), _tls(settings), *_services(settings)]
    return findings


def _tried(subject: str, attempt: Callable[[], str]) -> Finding:
    try:
        return Finding(subject, True, attempt())
    except StartError as error:
        return Finding(subject, False, str(error))


def _python() -> Finding:
    version = ".".join(map(str, sys.version_info[:3]))
    is_ok = sys.version_info >= (3, 11)
    return Finding("python", is_ok, version if is_ok else f"{version}: install Python 3.11 or newer")


def _packages() -> Iterator[Finding]:
    for name in ("nicegui", "paho-mqtt", "pydantic", "sqlalchemy", "shapely", "pyproj"):
        try:
            yield Finding(name, True, metadata.version(name))
        except metadata.PackageNotFoundError:
            yield Finding(name, False, "not installed: pip install --require-hashes -r requirements.txt")


def _clock() -> Finding:
    now = datetime.now(UTC)
    if now.year < EARLIEST_HONEST_YEAR:
        return Finding("clock", False, f"says {now:%Y-%m-%d %H:%M} UTC: set it, e.g. by NTP; records carry this time")
    started_s = time.monotonic()
    is_running = time.monotonic() >= started_s
    return Finding("clock", is_running, f"{now:%Y-%m-%d %H:%M:%S} UTC; safety rules do not depend on it")


def _broker(settings: Settings) -> Finding:
    if settings.demo:
        found = find_mosquitto()
        return Finding("broker", True, f"the demo starts {found or 'amqtt (mosquitto is not installed)'}")
    try:
        url = BrokerUrl.parse(settings.broker_url)
    except ValueError as error:
        return Finding("broker", False, str(error))
    if not answers(url.host, url.port):
        return Finding("broker", False, f"nothing answers at {url}: start the broker or set HEADLAND_BROKER_URL")
    is_open = url.host not in ("127.0.0.1", "localhost", "::1") and not (url.is_tls and url.username)
    if is_open:
        return Finding("broker", False, f"{url} is reached without TLS and credentials: use mqtts://user:password@...")
    return Finding("broker", True, f"{url} answers")


def _ports(settings: Settings) -> Iterator[Finding]:
    parts = (read_json(settings.data / "run" / "keeper.json") or {}).get("parts", {})
    if parts.get("console", {}).get("state") == "ok":
        yield Finding("ports", True, "in use by Headland itself, which is running")
        return
    for port, name in ((settings.port, "HEADLAND_PORT"), (settings.stop_port, "HEADLAND_STOP_PORT")):
        yield _tried(f"port {port}", lambda port=port, name=name: _free(settings.host, port, name))  # type: ignore[misc]


def _free(host: str, port: int, name: str) -> str:
    require_free(host, port, name)
    return "free"


def _services(settings: Settings) -> Iterator[Finding]:
    """Ask the services outside that are set; farms without any load nothing for it."""
    if settings.cloud_url or settings.planner_url or settings.forecast_url:
        from hmi.keeper.service_checkup import cloud_answers, forecast_answers, planner_answers

        if settings.cloud_url:
            yield Finding("cloud", *cloud_answers(settings))
        if settings.planner_url:
            yield Finding("planner service", *planner_answers(settings))
        if settings.forecast_url:
            yield Finding("weather forecast", *forecast_answers(settings))


def _tls(settings: Settings) -> Finding:
    if settings.tls_cert is None or settings.tls_key is None:
        return Finding(
            "tls", True, "off; position of the tablet and keeping its screen awake need it (`headland cert`)"
        )
    missing = [str(path) for path in (settings.tls_cert, settings.tls_key) if not path.is_file()]
    return Finding("tls", not missing, f"cannot read {', '.join(missing)}" if missing else str(settings.tls_cert))
