"""Nodes, functions and logs by REST."""

from __future__ import annotations

from typing import Any

import pytest

from hmi.domain.machine import FunctionInfo, NodeInfo
from hmi.domain.robot import Node, Stamp
from hmi.domain.robot_log import LogFailed, search
from hmi.domain.role import Role
from tests.hmi.api.console import Console
from tests.hmi.commands.field import factsheet


def furnish(console: Console, state: str = "started") -> None:
    """Give the weeder a node and two functions."""
    now_s = console.field.clock.mono_s()
    console.field.weeder.factsheet = factsheet(
        nodes=(NodeInfo("guidance", "Guidance", "Drive", 20.0, ()),),
        functions=(
            FunctionInfo("follow-path", "Follow a path", ("guidance",)),
            FunctionInfo("treat", "Weed", ("follow-path",)),
        ),
    )
    node = Node("guidance", state, 20.0, 6.0, 1, "", Stamp(now_s, now_s), "main", now_s - 5000, 0.002)
    console.field.weeder.nodes = {"guidance": node}


async def test_nodes_and_functions_come_as_on_the_live_lane(console: Console) -> None:
    furnish(console, "failure")
    client = await console.browser(Role.VIEWER)
    [node] = (await client.get("/robots/weeder-01/nodes")).json()["nodes"]
    assert (node["name"], node["state"], node["usual_hz"], node["offset_ms"]) == ("guidance", "failure", 20.0, 2.0)
    assert (node["finding"], node["level"], node["off"]) == ("Failed.", 2, ["Follow a path", "Weed"])
    told = (await client.get("/robots/weeder-01/functions")).json()
    assert [(one["name"], one["state"], one["depth"]) for one in told["functions"]] == [
        ("treat", "off", 0),
        ("follow-path", "off", 1),
    ]
    assert (told["on"], told["total"], told["hint"]) == (0, 2, "To turn on Weed: restart Guidance.")


async def test_a_robot_that_told_nothing_has_no_nodes_and_no_functions(console: Console) -> None:
    client = await console.browser(Role.VIEWER)
    assert (await client.get("/robots/weeder-01/nodes")).json()["nodes"] == []
    assert (await client.get("/robots/weeder-01/functions")).json()["functions"] == []
    assert (await client.get("/robots/weeder-99/nodes")).status_code == 404


async def test_an_admin_restarts_a_node(console: Console) -> None:
    furnish(console)
    client = await console.browser(Role.ADMIN)
    body = {"command_id": "restart-0001", "tick": console.field.tick()}
    answer = await client.post("/robots/weeder-01/nodes/guidance/restart", json=body)
    assert answer.json() == {"command_id": "restart-0001", "outcome": "accepted", "code": "ok", "text": "", "ms": 0}
    [order] = console.field.weeder.orders
    assert (order.action, order.node) == ("node_restart", "guidance")  # type: ignore[union-attr]


@pytest.mark.parametrize(
    ("path", "body", "status"),
    [
        ("nodes/tail-light/restart", {}, 404),
        ("nodes/guidance/explode", {}, 422),
        ("nodes/GUIDANCE/restart", {}, 422),
        ("commands", {"action": "node_stop"}, 422),
        ("commands", {"action": "go_to"}, 422),
        ("commands", {"action": "go_to", "place": [1.0, 2.0]}, 422),
        ("commands", {"action": "go_to", "place": [1.0, 2.0, 1e9]}, 422),
    ],
)
async def test_an_order_that_makes_no_sense_is_an_error(
    console: Console, path: str, body: dict[str, Any], status: int
) -> None:
    furnish(console)
    client = await console.browser(Role.ADMIN)
    whole = {"command_id": "restart-0001", "tick": console.field.tick(), **body}
    answer = await client.post(f"/robots/weeder-01/{path}", json=whole)
    assert answer.status_code in (status, 400), answer.text
    assert console.field.weeder.orders == []


async def test_a_place_travels_to_the_robot(console: Console) -> None:
    client = await console.browser(Role.OPERATOR)
    body = {"command_id": "go-to-0001", "tick": console.field.tick(), "action": "go_to", "place": [1.5, -2.0, 0]}
    answer = await client.post("/robots/weeder-01/commands", json=body)
    assert answer.json()["outcome"] == "accepted", answer.text
    assert console.field.weeder.orders[0].place == (1.5, -2.0, 0.0)  # type: ignore[union-attr]


async def test_the_end_of_the_log_is_read_and_searched_here(console: Console) -> None:
    console.logs.lines = [f"{i}.000 drive pulse {i}" for i in range(500)] + ["600.1 Crane failed", "600.2 crane-2 ok"]
    client = await console.browser(Role.OPERATOR)
    plain = (await client.get("/robots/weeder-01/logs", params={"lines": 3})).json()
    assert plain == {
        "lines": ["499.000 drive pulse 499", "600.1 Crane failed", "600.2 crane-2 ok"],
        "found": 3,
        "read": 3,
    }
    searched = (await client.get("/robots/weeder-01/logs", params={"q": "FAILED"})).json()
    assert searched == {"lines": ["600.1 Crane failed"], "found": 1, "read": 502}
    of_node = (await client.get("/robots/weeder-01/logs", params={"node": "crane"})).json()
    assert of_node["lines"] == ["600.1 Crane failed"]
    few = (await client.get("/robots/weeder-01/logs", params={"q": "pulse", "lines": 2})).json()
    assert (few["lines"], few["found"]) == (["498.000 drive pulse 498", "499.000 drive pulse 499"], 500)


@pytest.mark.parametrize("params", [{"lines": 0}, {"lines": 2001}, {"q": "x" * 101}, {"lines": "all"}])
async def test_a_log_is_asked_for_within_bounds(console: Console, params: dict[str, Any]) -> None:
    client = await console.browser(Role.OPERATOR)
    assert (await client.get("/robots/weeder-01/logs", params=params)).status_code in (400, 422)
    assert console.logs.asked == []


@pytest.mark.parametrize(("code", "status"), [("no_address", 409), ("no_answer", 504), ("broken", 502)])
async def test_a_log_that_cannot_be_read_says_why(console: Console, code: str, status: int) -> None:
    console.logs.trouble = LogFailed(code, "The robot did not give its log: no answer. Try again.")
    client = await console.browser(Role.OPERATOR)
    answer = await client.get("/robots/weeder-01/logs")
    assert (answer.status_code, answer.json()["code"]) == (status, code)
    assert answer.json()["text"] == "Weeder 01 did not give its log: no answer. Try again."


def test_a_node_is_found_as_a_word_of_its_own() -> None:
    lines = ["1 crane up", "2 crane-2 up", "3 the crane", "4 cranes", "5 (crane) x", "6 hoist_crane", ""]
    assert search(lines, node="crane") == ["1 crane up", "3 the crane", "5 (crane) x"]
    assert search(lines, words="UP") == ["1 crane up", "2 crane-2 up"]
