"""Base maps over REST: who may add them, what is refused, what a browser gets."""

from __future__ import annotations

import asyncio
from pathlib import Path
from typing import Any

import httpx
import pytest

from hmi.api.base_maps import OnlineMap
from hmi.domain.role import Role
from tests.hmi.base_maps.conftest import BaseMapRig
from tests.hmi.base_maps.photos import picture_tile, write_archive, write_photo
from tests.hmi.missions.rig import OTHER_FARM

PLACE = (12, 2096, 1357)
BLUE = picture_tile((10, 20, 200))


@pytest.fixture
def archive(tmp_path: Path) -> bytes:
    return write_archive(tmp_path / "a.pmtiles", {PLACE: BLUE}, {"attribution": "© Survey"}).read_bytes()


async def settled(client: httpx.AsyncClient) -> dict[str, Any]:
    """Return the shelf once nothing is being made any more."""
    while True:
        shelf: dict[str, Any] = (await client.get("/base-maps")).json()
        if all(one["state"] == "failed" for one in shelf["work"]):
            return shelf
        await asyncio.sleep(0)


async def upload(client: httpx.AsyncClient, data: bytes, name: str = "Farm_2026.pmtiles") -> httpx.Response:
    """Send a file."""
    return await client.post("/base-maps", params={"name": name}, content=data)


async def added(client: httpx.AsyncClient, data: bytes) -> dict[str, Any]:
    """Add a base map and return it."""
    answer = await upload(client, data)
    assert answer.status_code == 202, answer.text
    shelf = await settled(client)
    assert not shelf["work"], shelf["work"]
    found: dict[str, Any] = next(one for one in shelf["maps"] if one["id"] == answer.json()["id"])
    return found


async def test_a_planner_adds_a_map_and_everybody_of_the_farm_gets_its_tiles(rig: BaseMapRig, archive: bytes) -> None:
    async with rig.browser(Role.PLANNER) as planner:
        one = await added(planner, archive)
    assert (one["name"], one["kind"], one["credit"], one["by"]) == ("Farm 2026", "raster", "© Survey", "Planner Person")
    assert one["size_bytes"] == len(archive)
    assert one["is_there"]
    async with rig.browser(Role.VIEWER) as viewer:
        tile = await viewer.get(f"/base-maps/{one['id']}/12/2096/1357")
        again = await viewer.get(tile.url, headers={"If-None-Match": tile.headers["etag"]})
        nothing = await viewer.get(f"/base-maps/{one['id']}/12/0/0")
    assert (tile.content, tile.headers["content-type"]) == (BLUE, "image/png")
    assert tile.headers["cache-control"].startswith("private")
    assert (again.status_code, again.content) == (304, b"")
    assert nothing.status_code == 200
    assert len(nothing.content) < 100  # a clear pixel: a hole in a map is no failure
    assert [entry.outcome for entry in rig.audit.entries] == ["added"]
    assert rig.events[-1]["what"] == "ready"


async def test_a_photo_is_made_into_a_map(rig: BaseMapRig, tmp_path: Path) -> None:
    async with rig.browser(Role.PLANNER) as planner:
        one = await added(planner, write_photo(tmp_path / "photo.tif").read_bytes())
        assert (one["kind"], one["tile_px"]) == ("photo", 512)
        west, south, east, north = one["bounds"]
        assert 4 < west < east < 5
        assert 51 < south < north < 52
    assert not list((rig.folder / "incoming").iterdir())  # the photo itself is not kept


@pytest.mark.parametrize("role", [Role.VIEWER, Role.OPERATOR, Role.DISPATCHER])
async def test_who_may_not_edit_maps_cannot_change_base_maps(rig: BaseMapRig, archive: bytes, role: Role) -> None:
    async with rig.browser(Role.PLANNER) as planner:
        one = await added(planner, archive)
    async with rig.browser(role) as other:
        answers = [
            await upload(other, archive),
            await other.patch(f"/base-maps/{one['id']}", json={"name": "Mine"}),
            await other.delete(f"/base-maps/{one['id']}"),
        ]
        assert [answer.status_code for answer in answers] == [403, 403, 403]
        assert (await other.get("/base-maps")).json()["maps"][0]["name"] == "Farm 2026"


async def test_another_farm_sees_neither_map_nor_tile_nor_work(rig: BaseMapRig, archive: bytes) -> None:
    async with rig.browser(Role.PLANNER) as planner, rig.browser(Role.ADMIN, OTHER_FARM) as stranger:
        one = await added(planner, archive)
        rig.maker.go_on.clear()
        work = (await upload(planner, archive, "second.pmtiles")).json()
        shelf = (await stranger.get("/base-maps")).json()
        assert (shelf["maps"], shelf["work"], shelf["room"]["used_bytes"]) == ([], [], 0)
        for answer in (
            await stranger.get(f"/base-maps/{one['id']}/12/2096/1357"),
            await stranger.patch(f"/base-maps/{one['id']}", json={"name": "Mine"}),
            await stranger.delete(f"/base-maps/{one['id']}"),
            await stranger.delete(f"/base-maps/{work['id']}"),
        ):
            assert answer.status_code == 404
        assert (await planner.delete(f"/base-maps/{work['id']}")).status_code == 204


async def test_deleting_removes_the_file_and_makes_room(rig: BaseMapRig, archive: bytes) -> None:
    async with rig.browser(Role.PLANNER) as planner:
        one = await added(planner, archive)
        assert len(list(rig.folder.rglob("*.pmtiles"))) == 1
        assert (await planner.delete(f"/base-maps/{one['id']}")).status_code == 204
        assert not list(rig.folder.rglob("*.pmtiles"))
        assert (await planner.get("/base-maps")).json()["room"]["used_bytes"] == 0
        assert (await planner.get(f"/base-maps/{one['id']}/12/2096/1357")).status_code == 404
        assert (await planner.delete(f"/base-maps/{one['id']}")).status_code == 404


async def test_a_map_is_renamed_and_its_source_named(rig: BaseMapRig, archive: bytes) -> None:
    async with rig.browser(Role.PLANNER) as planner:
        one = await added(planner, archive)
        answer = await planner.patch(f"/base-maps/{one['id']}", json={"name": " Spring  flight ", "credit": "© Drone"})
        assert (answer.json()["name"], answer.json()["credit"]) == ("Spring flight", "© Drone")
        for bad in ({"name": ""}, {"name": "x" * 81}, {"name": "a", "credit": "x" * 161}, {"name": "a", "owner": "me"}):
            assert (await planner.patch(f"/base-maps/{one['id']}", json=bad)).status_code == 422


async def test_what_is_no_map_is_kept_in_the_list_with_what_to_do_until_it_is_dismissed(rig: BaseMapRig) -> None:
    async with rig.browser(Role.PLANNER) as planner:
        await upload(planner, b"PK\3\4 a zip", "photo.zip")
        [failed] = (await settled(planner))["work"]
        assert (failed["state"], failed["code"]) == ("failed", "unknown_format")
        assert "GeoTIFF" in failed["text"]
        assert (await planner.delete(f"/base-maps/{failed['id']}")).status_code == 204
        assert (await settled(planner))["work"] == []


async def test_the_same_map_twice_is_said_and_kept_once(rig: BaseMapRig, archive: bytes) -> None:
    async with rig.browser(Role.PLANNER) as planner:
        one = await added(planner, archive)
        await upload(planner, archive, "again.pmtiles")
        [failed] = (await settled(planner))["work"]
        assert "already: Farm 2026" in failed["text"]
        assert (await planner.get(f"/base-maps/{one['id']}/12/2096/1357")).content == BLUE


async def test_a_file_over_the_limit_is_refused_whether_it_says_its_size_or_not(rig: BaseMapRig) -> None:
    rig.base_maps = rig.book_with(upload_bytes=1_000_000)

    async def unsaid() -> Any:
        for _ in range(30):
            yield b"x" * 100_000

    async with rig.browser(Role.PLANNER) as planner:
        for content in (b"x" * 1_000_001, unsaid()):
            answer = await planner.post("/base-maps", params={"name": "big.tif"}, content=content)
            assert (answer.status_code, answer.json()["code"]) == (413, "too_large")
            assert "1 MB" in answer.json()["text"]
        assert (await planner.get("/base-maps")).json()["work"] == []
    assert not list((rig.folder / "incoming").iterdir())


async def test_a_farm_that_filled_its_room_is_told_to_delete_one(rig: BaseMapRig, archive: bytes) -> None:
    rig.base_maps = rig.book_with(farm_bytes=len(archive) + 10)
    async with rig.browser(Role.PLANNER) as planner:
        await added(planner, archive)
        await upload(planner, archive + b"!" * 100)
        [failed] = (await settled(planner))["work"]
        assert failed["code"] == "no_room"
        assert "Delete one" in failed["text"]
    rig.base_maps = rig.book_with(farm_bytes=len(archive))
    async with rig.browser(Role.PLANNER) as planner:
        answer = await upload(planner, archive)
        assert (answer.status_code, answer.json()["code"]) == (409, "no_room")


async def test_work_tells_how_far_it_is_and_ends_when_it_is_cancelled(rig: BaseMapRig, archive: bytes) -> None:
    rig.maker.go_on.clear()
    async with rig.browser(Role.PLANNER) as planner:
        work = (await upload(planner, archive)).json()
        await rig.maker.begun.wait()
        [shown] = (await planner.get("/base-maps")).json()["work"]
        assert (shown["state"], shown["share"], shown["is_mine"]) == ("working", 0.5, True)
        assert (await planner.delete(f"/base-maps/{work['id']}")).status_code == 204
        shelf = (await planner.get("/base-maps")).json()
        assert (shelf["work"], shelf["maps"]) == ([], [])
    assert not list((rig.folder / "incoming").iterdir())


async def test_a_fourth_upload_waits_for_the_others(rig: BaseMapRig, archive: bytes) -> None:
    rig.maker.go_on.clear()
    async with rig.browser(Role.PLANNER) as planner:
        ids = [(await upload(planner, archive, f"{n}.pmtiles")).json()["id"] for n in range(3)]
        answer = await upload(planner, archive)
        assert (answer.status_code, answer.json()["code"]) == (409, "busy")
        for one in ids:
            await planner.delete(f"/base-maps/{one}")


async def test_a_map_whose_file_is_gone_says_so(rig: BaseMapRig, archive: bytes) -> None:
    async with rig.browser(Role.PLANNER) as planner:
        one = await added(planner, archive)
        next(rig.folder.rglob("*.pmtiles")).unlink()
        assert (await planner.get("/base-maps")).json()["maps"][0]["is_there"] is False
        answer = await planner.get(f"/base-maps/{one['id']}/12/2096/1357")
        assert (answer.status_code, answer.json()["code"]) == (410, "file_gone")


@pytest.mark.parametrize("name", ["../../etc/passwd.pmtiles", "..\\..\\x.pmtiles", "/abs.pmtiles", "\x00\x07.pmtiles"])
async def test_a_name_that_points_elsewhere_is_only_a_name(rig: BaseMapRig, archive: bytes, name: str) -> None:
    async with rig.browser(Role.PLANNER) as planner:
        answer = await upload(planner, archive, name)
        assert "/" not in answer.json()["name"]
        await settled(planner)
    [kept] = rig.folder.rglob("*.pmtiles")
    assert kept.parent == rig.folder / "farm"


@pytest.mark.parametrize("path", ["..%2F..%2Fx/1/0/0", "abc/99/0/0", "abc/1/-1/0", "abc/1/0/x", "ABC/1/0/0"])
async def test_an_address_that_names_no_tile_is_refused(rig: BaseMapRig, path: str) -> None:
    async with rig.browser(Role.VIEWER) as viewer:
        assert (await viewer.get(f"/base-maps/{path}")).status_code in (404, 422)


async def test_an_online_map_is_told_only_where_an_admin_set_one(rig: BaseMapRig) -> None:
    async with rig.browser(Role.VIEWER) as viewer:
        assert (await viewer.get("/base-maps")).json()["online"] is None
    there = OnlineMap("https://tiles.example/{z}/{x}/{y}.png", "© Example", 17)
    async with rig.browser(Role.VIEWER, online=there) as viewer:
        assert (await viewer.get("/base-maps")).json()["online"] == {
            "url": there.url, "credit": "© Example", "max_zoom": 17,
        }  # fmt: skip


async def test_what_an_earlier_console_left_unfinished_is_thrown_away(rig: BaseMapRig) -> None:
    left = rig.folder / "incoming" / "abc"
    left.mkdir(parents=True)
    (left / "upload").write_bytes(b"half")
    await rig.base_maps.prepare()
    assert not left.exists()
