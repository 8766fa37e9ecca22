"""A small wish, and a service that is played."""

from __future__ import annotations

import json
from collections.abc import Awaitable, Callable
from typing import Any

import httpx
from pydantic import SecretStr

from backend_clients.planner.client import PlannerClient, limited
from backend_clients.planner.messages import Datum, Machine, Treatment, Wish
from backend_clients.service.connection import Service

MACHINE = Machine(
    length_m=2.6, width_m=1.7, base_to_front_m=1.3, turning_radius_m=1.0, can_pivot=True, row_speed_mps=0.45,
    turn_speed_mps=0.3, transit_speed_mps=1.0, accel_mps2=0.4, yaw_rate_radps=0.6, margin_m=0.1,
)  # fmt: skip
RING = [(4.26, 51.78), (4.2606, 51.78), (4.2606, 51.7804), (4.26, 51.7804), (4.26, 51.78)]
WISH = Wish(
    datum=Datum(lat_deg=51.78, lon_deg=4.26),
    field=[RING],
    machine=MACHINE,
    width_m=3.0,
    overlap=0.0,
    treatment=Treatment(lead_in_m=0.3, lead_out_m=0.1),
)
PATH = {"segments": [{"kind": "row", "points": [[0, 0], [10, 0]], "speed_mps": 0.4, "tool_on": True, "row": 1}]}
SERVICE = limited(Service("http://planner.test/v1", SecretStr("secret-token")))
Answer = Callable[[httpx.Request], httpx.Response]


class PlayedService:
    """Takes a wish and answers what the test says; notes what it was asked."""

    def __init__(self, *states: dict[str, Any]) -> None:
        self.states = list(states)
        self.asked: list[tuple[str, str]] = []
        self.headers: list[httpx.Headers] = []
        self.sha256 = self.id = ""
        self.slept: list[float] = []
        self.instead: Answer | None = None

    def __call__(self, request: httpx.Request) -> httpx.Response:
        """Answer one request."""
        self.asked.append((request.method, request.url.path))
        self.headers.append(request.headers)
        if self.instead is not None:
            return self.instead(request)
        if request.method == "DELETE":
            return httpx.Response(204)
        if request.method == "POST":
            self.sha256 = json.loads(request.content)["wish_sha256"]
            self.id = request.headers["idempotency-key"]
        told = self.states.pop(0) if len(self.states) > 1 else self.states[0]
        whole = {"v": 1, "id": self.id, "wish_sha256": self.sha256, **told}
        return httpx.Response(202 if request.method == "POST" else 200, json=whole)

    async def sleep(self, seconds: float) -> None:
        """Note a wait instead of waiting."""
        self.slept.append(seconds)

    def client(self, limit_s: float = 30.0, sleep: Callable[[float], Awaitable[None]] | None = None) -> PlannerClient:
        """Return a client of this service, on a clock that only its waits move."""
        transport, mono_s = httpx.MockTransport(self), lambda: sum(self.slept)
        return PlannerClient(SERVICE, limit_s, transport=transport, sleep=sleep or self.sleep, mono_s=mono_s)
