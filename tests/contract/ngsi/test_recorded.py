"""What a real Orion 4.3 answered, asked again in the same order; ``HEADLAND_TEST_NGSI_URL`` names another broker.

A broker named there must be empty in tenant ``g1``.
"""

from __future__ import annotations

import json
import os
import re
from pathlib import Path
from typing import Any

import httpx

from backend_clients.simulator.context_broker.application import make_application
from backend_clients.simulator.context_broker.broker import ContextBroker

RECORDED = json.loads((Path(__file__).parent / "recorded" / "orion-4.3.json").read_text(encoding="utf-8"))["cases"]
HEADERS = ("Location", "Fiware-Total-Count", "Content-Type", "Allow")
DATE = re.compile(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d\.\d{3}Z")
RECORDED_NOW = re.compile(r"2026-11-20T2\d:\d\d:\d\d\.\d{3}Z")


def asked(case: dict[str, Any]) -> httpx.Request:
    """Return the request of a case as it went over the wire."""
    request = case["request"]
    body = request["body"]
    content = None if body is None else (body if isinstance(body, str) else json.dumps(body)).encode()
    return httpx.Request(
        request["method"], "http://broker" + request["path"], headers=request["headers"], content=content
    )


def dateless(value: Any) -> Any:
    """Return a body with the times of the recording, and those of today, made alike."""
    text = json.dumps(value)
    today = {found for found in DATE.findall(text) if RECORDED_NOW.fullmatch(found) or not found.startswith("2026-05")}
    for found in today:
        text = text.replace(found, "now")
    return json.loads(text)


def difference(case: dict[str, Any], response: httpx.Response) -> str:
    """Return what of an answer is not as recorded, empty if all is."""
    wanted = case["response"]
    body = json.loads(response.text) if response.content else None
    headers = {name: response.headers[name] for name in HEADERS if name in response.headers}
    if response.status_code != wanted["status"]:
        return f"{case['name']}: {response.status_code} {response.text[:200]}, recorded {wanted}"
    if dateless(body) != dateless(wanted["body"]) or headers != wanted["headers"]:
        return f"{case['name']}: {headers} {body}, recorded {wanted}"
    return ""


async def test_every_recorded_answer_of_orion_is_given_again() -> None:
    url = os.environ.get("HEADLAND_TEST_NGSI_URL", "http://broker")
    broker = ContextBroker()
    transport = None if "HEADLAND_TEST_NGSI_URL" in os.environ else httpx.ASGITransport(make_application(broker))
    async with httpx.AsyncClient(transport=transport) as client:
        wrong = []
        for case in RECORDED:
            request = asked(case)
            request.url = httpx.URL(url).join(case["request"]["path"])
            if difference(case, response := await client.send(request)):
                wrong.append(difference(case, response))
    await broker.close()
    assert len(RECORDED) == 185
    assert not wrong, f"{len(wrong)} of {len(RECORDED)} differ:\n" + "\n".join(wrong)
