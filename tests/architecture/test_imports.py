"""Imports point one way: the table of docs/architecture.md, read from the source."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PURE = {"hmi.domain", "hmi.planning", "hmi.clock", "hmi.settings"}
EVERYTHING = {"hmi", "components", "backend_clients", "nicegui"}
ALLOWED: dict[str, set[str]] = {
    "backend_clients.simulator": {"backend_clients", "hmi.domain", "hmi.planning", "hmi.clock"},
    "backend_clients.simulator.context_broker": {"backend_clients.simulator.context_broker", "hmi.clock"},
    "backend_clients.http": {"backend_clients.http", "backend_clients.errors", "backend_clients.trust"},
    "backend_clients.ngsi": {"backend_clients.ngsi", "backend_clients.http"},
    "backend_clients.service": {"backend_clients.service", "backend_clients.http"},
    "backend_clients": {"backend_clients"},
    "hmi.service_link": {"backend_clients.http.trouble", "hmi.clock"},
    "hmi.planning_service": {"hmi.planning_service", "hmi.planning", "hmi.domain", "hmi.service_link", "hmi.clock",
                             "backend_clients.planner", "backend_clients.service"},
    "hmi.forecast": {"hmi.forecast", "hmi.domain", "hmi.service_link", "hmi.clock", "backend_clients.forecast",
                     "backend_clients.service"},
    "hmi.domain": PURE,
    "hmi.planning": PURE,
    "hmi.clock": PURE,
    "hmi.settings": PURE,
    "hmi.fiware": {"hmi.fiware", "hmi.domain", "hmi.mapping", "backend_clients.ngsi"},
    "hmi.map_files": {"hmi.map_files", "hmi.fiware", "hmi.mapping", "hmi.planning.side_process", "hmi.domain",
                      "hmi.clock"},
    "hmi.cloud": {"hmi.cloud", "hmi.fiware", "hmi.mapping", "backend_clients.ngsi", "backend_clients.cloud_robot",
                  "backend_clients.http", "hmi.domain", "hmi.store", "hmi.service_link", "hmi.clock"},
    "hmi.base_maps": {"hmi.base_maps", "hmi.planning.side_process", "hmi.domain", "hmi.clock"},
    "hmi.mapping": PURE | {"hmi.mapping"},
    "hmi.store": {"hmi.store", "hmi.domain", "hmi.clock", "hmi.settings"},
    "hmi.presenters": {"hmi.presenters", "hmi.domain", "hmi.clock", "hmi.settings"},
    "hmi.security": {"hmi.security", "hmi.domain", "hmi.store", "hmi.settings", "hmi.clock"},
    "hmi.ingest": {"hmi.ingest", "backend_clients", "hmi.domain", "hmi.store", "hmi.clock"},
    "hmi.commands": {"hmi.commands", "hmi.domain", "hmi.mapping", "hmi.map_files", "hmi.store", "hmi.security",
                     "hmi.clock", "hmi.base_maps", "hmi.notifications"},
    "hmi.notifications": {"hmi.notifications", "hmi.domain", "hmi.store", "hmi.clock"},
    "hmi.live": {"hmi.live", "hmi.domain", "hmi.store", "hmi.presenters", "hmi.security", "hmi.clock"},
    "hmi.lean_start": set(),
    "hmi.side_door": set(),
    "hmi.side_server": {"hmi.side_door"},
    "hmi.stop_gateway": {"hmi.stop_gateway", "hmi.lean_start", "hmi.domain", "hmi.clock", "hmi.settings",
                         "backend_clients.edge", "backend_clients.errors"},
    "hmi.twin": {"hmi.twin", "backend_clients.edge", "hmi.domain", "hmi.clock"},
    "hmi.media": {"hmi.media", "hmi.twin", "backend_clients.edge", "backend_clients.errors", "hmi.domain", "hmi.clock",
                  "hmi.settings", "hmi.planning.side_process", "hmi.side_door", "hmi.side_server"},
    "hmi.cameras": {"hmi.cameras", "hmi.domain", "hmi.clock", "hmi.settings", "hmi.side_door",
                    "hmi.side_server", "hmi.planning.side_process"},
    "hmi.api": {"hmi.api", "hmi.domain", "hmi.store", "hmi.presenters", "hmi.commands", "hmi.security", "hmi.planning",
                "hmi.mapping", "hmi.map_files", "hmi.base_maps", "hmi.reports", "hmi.clock", "hmi.settings",
                "hmi.notifications"},
    "hmi.pages": {"hmi.pages", "nicegui", "components", "hmi.domain", "hmi.presenters", "hmi.store", "hmi.live",
                  "hmi.commands", "hmi.security", "hmi.settings", "hmi.clock"},
    "hmi.app": EVERYTHING,
    "hmi.cli": EVERYTHING,
    "hmi.keeper": EVERYTHING,
    "hmi.demo": EVERYTHING,
    "hmi.__main__": EVERYTHING,
    "hmi": {"hmi"},
    "components": {"components", "nicegui"},
}  # fmt: skip
CHECKED = ("hmi", "components", "backend_clients", "nicegui")


def modules() -> list[Path]:
    """Return every source module of ours."""
    return sorted(p for top in ("hmi", "components", "backend_clients") for p in (ROOT / top).rglob("*.py"))


def name_of(path: Path) -> str:
    """Return the dotted name of a module."""
    parts = path.relative_to(ROOT).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def rule_for(module: str) -> set[str]:
    """Return what ``module`` may import: the longest package of the table that holds it."""
    package = max((p for p in ALLOWED if module == p or module.startswith(p + ".")), key=len)
    return ALLOWED[package]


def imported(path: Path) -> set[str]:
    """Return the dotted names that ``path`` imports, first-party and nicegui only."""
    names: set[str] = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            assert node.level == 0, f"{path}: relative import"
            names |= {f"{node.module}.{alias.name}" for alias in node.names}
    return {n for n in names if n.split(".")[0] in CHECKED}


def is_covered(name: str, allowed: set[str]) -> bool:
    """Say whether an imported name lies in one of the allowed packages."""
    return any(name == package or name.startswith(package + ".") for package in allowed)


@pytest.mark.parametrize("path", modules(), ids=name_of)
def test_module_imports_only_what_its_room_may(path: Path) -> None:
    allowed = rule_for(name_of(path))
    stray = {
        name for name in imported(path) if name not in {"hmi", "hmi.__version__"} and not is_covered(name, allowed)
    }
    assert not stray


@pytest.mark.slow
def test_the_simulator_is_reached_from_the_demo_and_the_command_line_only() -> None:
    users = {
        name_of(path)
        for path in modules()
        for name in imported(path)
        if name.startswith("backend_clients.simulator") and not name_of(path).startswith("backend_clients.simulator")
    }
    assert all(user.startswith(("hmi.demo", "hmi.cli", "hmi.keeper", "hmi.app")) for user in users), users


@pytest.mark.parametrize("path", modules(), ids=name_of)
def test_no_module_is_longer_than_500_lines(path: Path) -> None:
    assert len(path.read_text(encoding="utf-8").splitlines()) <= 500
