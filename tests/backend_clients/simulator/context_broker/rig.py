"""A broker without a network, asked in a line; notifications come into a list."""

from __future__ import annotations

import json
from typing import Any

import httpx
from starlette.datastructures import Headers, QueryParams

from backend_clients.simulator.context_broker.broker import ContextBroker
from hmi.clock import FakeClock


class Rig:
    """A broker with a clock that moves when told.

    Attributes:
        posted: notifications as they went out.
        answers: status codes the receiver gives in turn, then 204; 0 is no connection.
    """

    def __init__(self) -> None:
        self.clock = FakeClock()
        self.posted: list[httpx.Request] = []
        self.answers: list[int] = []
        self.broker = ContextBroker(self.clock, httpx.MockTransport(self._receive))

    def ask(
        self,
        method: str,
        path: str,
        body: Any = None,
        *,
        service: str = "g1",
        path_header: str = "/farm",
        raw: bytes = b"",
    ) -> tuple[int, Any]:
        """Return status and body of an answer."""
        answer = self.full(method, path, body, service=service, path_header=path_header, raw=raw)
        return answer.status, json.loads(answer.body) if answer.body else None

    def full(
        self,
        method: str,
        path: str,
        body: Any = None,
        *,
        service: str = "g1",
        path_header: str = "/farm",
        raw: bytes = b"",
    ) -> Any:
        """Return the whole answer."""
        content = raw or (b"" if body is None else json.dumps(body).encode())
        headers = {"Fiware-Service": service, "Fiware-ServicePath": path_header, "Fiware-Correlator": "c-1"}
        if content:
            headers["Content-Type"] = "application/json"
        where, _, query = path.partition("?")
        return self.broker.answer(method, where, QueryParams(query), Headers(headers), content)

    def make(self, which: str, **values: Any) -> None:
        """Make a robot from plain values."""
        status, said = self.ask("POST", "/v2/entities?options=keyValues", {"id": which, "type": "Robot", **values})
        assert status == 201, said

    def put(self, which: str, **values: Any) -> None:
        """Write plain values."""
        assert self.ask("POST", f"/v2/entities/{which}/attrs?options=keyValues", values)[0] == 204

    def subscribe(self, condition: dict[str, Any] | None = None, entities: Any = None, **more: Any) -> str:
        """Subscribe to robots; ``notification`` among ``more`` is added to the way it goes."""
        notification = {"http": {"url": "http://console/notify"}, **more.pop("notification", {})}
        subject = {"entities": entities or [{"idPattern": ".*", "type": "Robot"}], "condition": condition or {}}
        answer = self.full("POST", "/v2/subscriptions", {"subject": subject, "notification": notification, **more})
        assert answer.status == 201, answer.body
        return str(answer.headers["Location"].rpartition("/")[2])

    async def bodies(self) -> list[Any]:
        """Return the bodies of the notifications that went out since the last call."""
        await self.broker.notifier.settle()
        found = [json.loads(request.content) for request in self.posted]
        self.posted.clear()
        return found

    def _receive(self, request: httpx.Request) -> httpx.Response:
        self.posted.append(request)
        status = self.answers.pop(0) if self.answers else 204
        if not status:
            raise httpx.ConnectError("refused")
        return httpx.Response(status)
