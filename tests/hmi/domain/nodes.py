"""Robots with software nodes and functions, for tests of what can be judged from them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Any

from hmi.domain.machine import FunctionInfo, NodeInfo
from hmi.domain.robot import Node, Robot, Stamp
from tests.hmi.presenters import robots as r

NOW_S = 1000.0


def node(name: str, state: str = "started", **changes: Any) -> Node:
    """Return a healthy node as heard one second ago."""
    usual = Node(name, state, 10.0, 4.0, 0, "", Stamp(NOW_S - 1, NOW_S - 1), "main", NOW_S - 500, 0.001)
    return replace(usual, **changes)


def info(name: str, label: str = "", *, rate_hz: float | None = 10.0, after: Iterable[str] = ()) -> NodeInfo:
    """Return what a robot declares of a node."""
    return NodeInfo(name, label or name, "Drive", rate_hz, tuple(after))


def function(name: str, *needs: str, better: Iterable[str] = (), label: str = "") -> FunctionInfo:
    """Return a declared function."""
    return FunctionInfo(name, label or name.capitalize(), tuple(needs), tuple(better))


def robot(
    nodes: Iterable[Node] = (), functions: Iterable[FunctionInfo] = (), infos: Iterable[NodeInfo] = (), **sheet: Any
) -> Robot:
    """Return a running robot with these nodes and functions."""
    heard: Mapping[str, Node] = {one.name: one for one in nodes}
    changed = replace(r.SHEET, functions=tuple(functions), nodes=tuple(infos), **sheet)
    return replace(r.RUNNING, factsheet=changed, nodes=dict(heard))
