"""The console's second STOP path: who may press, and that nothing stands in the way."""

from __future__ import annotations

from hmi.domain.role import Role
from hmi.domain.stop_token import StopToken
from tests.hmi.api.console import SECRET, Console

BODY = {"stop_id": "stop-00000001", "robots": ["weeder-01"]}


def token(name: str = "") -> dict[str, str]:
    """Return the header of an enrolled tablet."""
    text = StopToken("tablet-3", "Tablet 3", "", name, "farm").sign(SECRET)
    return {"authorization": f"Bearer {text}"}


async def test_a_tablet_stops_without_anybody_signed_in(console: Console) -> None:
    answer = await console.client().post("/stop", json=BODY, headers=token())
    assert answer.status_code == 202
    assert answer.json()["steps"][0]["by"] == "Tablet 3"
    assert console.stop.presses[0][:2] == ("stop-00000001", ["weeder-01"])


async def test_everybody_who_signed_in_may_stop_everything(console: Console) -> None:
    for role in Role:
        client = await console.browser(role)
        answer = await client.post("/stop", json={"stop_id": f"stop-by-{role.value}", "robots": "all"})
        assert answer.status_code == 202, role
    assert [robots for _, robots, _ in console.stop.presses] == ["all"] * len(Role)


async def test_a_stale_token_beside_a_good_session_still_stops(console: Console) -> None:
    client = await console.browser(Role.VIEWER)
    answer = await client.post("/stop", json=BODY, headers={"authorization": "Bearer forged"})
    assert answer.status_code == 202


async def test_a_session_stops_even_when_its_csrf_token_went_stale(console: Console) -> None:
    client = await console.browser(Role.VIEWER)
    client.headers["x-headland-csrf"] = "old"
    assert (await client.post("/stop", json=BODY)).status_code == 202


async def test_a_forged_token_alone_does_not_stop(console: Console) -> None:
    answer = await console.client().post("/stop", json=BODY, headers={"authorization": "Bearer forged"})
    assert (answer.status_code, answer.json()["code"]) == (401, "bad_token")
    assert console.stop.presses == []


async def test_stop_is_never_limited(console: Console) -> None:
    client = console.client()
    answers = [await client.post("/stop", json=BODY, headers=token()) for _ in range(60)]
    assert {a.status_code for a in answers} == {202}
    assert len(console.stop.presses) == 60


async def test_a_press_can_be_asked_after(console: Console) -> None:
    client = console.client()
    await client.post("/stop", json=BODY, headers=token("Martha Keller"))
    answer = await client.get("/stop/stop-00000001", headers=token())
    assert answer.json()["steps"][0]["state"] == "sent"
    assert (await client.get("/stop/stop-00000009", headers=token())).status_code == 404
