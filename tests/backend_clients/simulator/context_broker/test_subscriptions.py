"""Who is notified of what, and what the broker says of it."""

from __future__ import annotations

from typing import Any

import pytest

from tests.backend_clients.simulator.context_broker.rig import Rig


def speeds(bodies: list[Any]) -> list[Any]:
    return [body["data"][0]["speed"]["value"] for body in bodies]


async def test_a_subscription_says_nothing_of_what_was_there() -> None:
    rig = Rig()
    rig.make("r1", speed=1)
    rig.subscribe()
    assert await rig.bodies() == []


async def test_a_change_notifies_and_the_same_value_does_not_unless_forced() -> None:
    rig = Rig()
    rig.make("r1", speed=1)
    rig.subscribe()
    rig.put("r1", speed=1)
    assert await rig.bodies() == []
    rig.put("r1", speed=2)
    assert speeds(await rig.bodies()) == [2]
    rig.ask("PATCH", "/v2/entities/r1/attrs?options=keyValues,forcedUpdate", {"speed": 2})
    assert speeds(await rig.bodies()) == [2]


async def test_only_attributes_of_the_condition_notify_and_only_wanted_ones_are_sent() -> None:
    rig = Rig()
    rig.make("r1", speed=1, name="x")
    rig.subscribe({"attrs": ["speed"]}, notification={"attrs": ["name", "dateModified"]})
    rig.put("r1", name="y")
    assert await rig.bodies() == []
    rig.put("r1", speed=2)
    (body,) = await rig.bodies()
    assert set(body["data"][0]) == {"id", "type", "name", "dateModified"}


async def test_an_expression_is_asked_of_the_entity_as_it_is_now() -> None:
    rig = Rig()
    rig.make("r1", speed=1)
    rig.subscribe({"expression": {"q": "speed>2"}})
    rig.put("r1", speed=2)
    rig.put("r1", speed=3)
    assert speeds(await rig.bodies()) == [3]


async def test_deleting_notifies_only_who_asked_for_it() -> None:
    rig = Rig()
    rig.subscribe()
    rig.subscribe({"alterationTypes": ["entityDelete"]}, notification={"attrs": ["alterationType"]})
    rig.make("r1", speed=1)
    assert len(await rig.bodies()) == 1
    rig.ask("DELETE", "/v2/entities/r1")
    (body,) = await rig.bodies()
    assert body["data"][0]["alterationType"]["value"] == "entityDelete"


async def test_throttling_is_of_the_subscription_and_loses_what_other_entities_say() -> None:
    rig = Rig()
    rig.subscribe(throttling=10)
    rig.make("r1", speed=1)
    rig.make("r2", speed=2)
    assert speeds(await rig.bodies()) == [1]
    rig.clock.advance(9.9)
    rig.put("r2", speed=3)
    assert await rig.bodies() == []
    rig.clock.advance(0.2)
    rig.put("r2", speed=4)
    assert speeds(await rig.bodies()) == [4]


async def test_an_end_is_kept_and_can_be_put_off() -> None:
    rig = Rig()
    name = rig.subscribe(expires="2026-05-04T12:00:10Z")
    rig.clock.advance(11)
    rig.make("r1", speed=1)
    assert await rig.bodies() == []
    assert rig.ask("GET", f"/v2/subscriptions/{name}")[1]["status"] == "expired"
    assert rig.ask("PATCH", f"/v2/subscriptions/{name}", {"expires": "2026-05-05T00:00:00Z"})[0] == 204
    rig.put("r1", speed=2)
    assert speeds(await rig.bodies()) == [2]


async def test_a_oneshot_speaks_once_and_an_inactive_one_not_at_all() -> None:
    rig = Rig()
    once = rig.subscribe(status="oneshot")
    rig.subscribe(status="inactive")
    rig.make("r1", speed=1)
    rig.put("r1", speed=2)
    assert speeds(await rig.bodies()) == [1]
    assert rig.ask("GET", f"/v2/subscriptions/{once}")[1]["status"] == "inactive"


async def test_failures_are_counted_and_end_it_at_the_limit() -> None:
    rig = Rig()
    name = rig.subscribe(notification={"maxFailsLimit": 2})
    rig.answers = [0, 500, 0, 0]
    rig.make("r1", speed=0)
    for speed in (1, 2, 3, 4):
        await rig.broker.notifier.settle()
        rig.put("r1", speed=speed)
    assert speeds(await rig.bodies()) == [0, 1, 2, 3]
    told = rig.ask("GET", f"/v2/subscriptions/{name}")[1]
    assert told["status"] == "inactive"
    assert (told["notification"]["timesSent"], told["notification"]["failsCounter"]) == (4, 2)
    assert told["notification"]["lastSuccessCode"] == 500
    assert "ConnectError" in told["notification"]["lastFailureReason"]


@pytest.mark.parametrize(
    ("form", "data"),
    [("normalized", {"id": "r1", "type": "Robot", "speed": {"type": "Number", "value": 1, "metadata": {}}}),
     ("keyValues", {"id": "r1", "type": "Robot", "speed": 1}), ("values", [1])],
)  # fmt: skip
async def test_a_notification_has_the_form_asked_for(form: str, data: Any) -> None:
    rig = Rig()
    name = rig.subscribe(notification={"attrsFormat": form})
    rig.make("r1", speed=1)
    await rig.broker.notifier.settle()
    headers = rig.posted[0].headers
    assert headers["ngsiv2-attrsformat"] == form
    assert (headers["fiware-service"], headers["fiware-servicepath"]) == ("g1", "/farm")
    assert headers["fiware-correlator"].startswith("c-1")
    assert await rig.bodies() == [{"subscriptionId": name, "data": [data]}]


async def test_a_simplified_notification_is_the_bare_entity_and_a_custom_one_has_its_own_headers() -> None:
    rig = Rig()
    way = {"url": "http://console/x", "headers": {"X-Key": "k"}, "qs": {"a": "b"}}
    rig.subscribe(notification={"attrsFormat": "simplifiedKeyValues", "onlyChangedAttrs": True})
    subject = {"entities": [{"id": "r1"}]}
    body = {"subject": subject, "notification": {"httpCustom": way, "attrs": []}}
    assert rig.ask("POST", "/v2/subscriptions", body)[0] == 201
    rig.make("r1", speed=1, name="x")
    await rig.bodies()
    rig.put("r1", speed=2)
    await rig.broker.notifier.settle()
    custom = next(request for request in rig.posted if request.url.path == "/x")
    assert (custom.headers["x-key"], custom.url.query) == ("k", b"a=b")
    assert {"id": "r1", "type": "Robot", "speed": 2} in await rig.bodies()


async def test_subscriptions_hear_only_their_own_path_and_tenant() -> None:
    rig = Rig()
    rig.subscribe()
    for service, path in (("g1", "/other"), ("g2", "/farm")):
        rig.ask("POST", "/v2/entities", {"id": "r1", "type": "Robot"}, service=service, path_header=path)
    assert await rig.bodies() == []
    assert rig.ask("GET", "/v2/subscriptions", service="g2")[1] == []


@pytest.mark.parametrize(
    "body",
    [{}, {"subject": {}, "notification": {}}, {"subject": {"entities": []}, "notification": {"http": {"url": "http://a"}}},
     {"subject": {"entities": [{"id": "a", "idPattern": "b"}]}, "notification": {"http": {"url": "http://a"}}},
     {"subject": {"entities": [{"id": "a"}]}, "notification": {"http": {"url": "ftp://a"}}},
     {"subject": {"entities": [{"id": "a"}]}, "notification": {"http": {"url": "http://a/?b=c"}}},
     {"subject": {"entities": [{"id": "a"}]}, "notification": {"http": {"url": "http://a"}}, "description": "it's"},
     {"subject": {"entities": [{"id": "a"}]}, "notification": {"http": {"url": "http://a"}}, "throttling": -1},
     {"subject": {"entities": [{"id": "a"}]}, "notification": {"http": {"url": "http://a"}}, "expires": "soon"},
     {"subject": {"entities": [{"id": "a"}]}, "notification": {"http": {"url": "http://a"}}, "colour": 1}],
)  # fmt: skip
def test_a_subscription_that_makes_no_sense_is_refused(body: Any) -> None:
    rig = Rig()
    assert rig.ask("POST", "/v2/subscriptions", body)[0] == 400
    assert rig.ask("GET", "/v2/subscriptions")[1] == []


def test_what_is_not_simulated_is_said() -> None:
    rig = Rig()
    subject = {"entities": [{"id": "a"}]}
    way = {"mqtt": {"url": "mqtt://a:1883", "topic": "t"}}
    assert rig.ask("POST", "/v2/subscriptions", {"subject": subject, "notification": way})[0] == 501
    assert rig.ask("POST", "/v2/registrations", {"a": 1})[0] == 501
