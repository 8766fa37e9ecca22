"""The live map in Chromium: what an operator sees for what the robot says."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import pytest
from playwright.sync_api import Browser, BrowserType, Page, ViewportSize, expect

from tests.components import map_field
from tests.components.map_page import BODY, ROBOT, ROW, MapPage, along_row
from tests.components.map_server import MapServer
from tests.components.screen_pixels import is_close

pytestmark = pytest.mark.browser

ENGINES = ["auto", pytest.param("canvas", marks=pytest.mark.long)]
SIZE: ViewportSize = {"width": 720, "height": 520}  # software GL pays for every pixel
CENTRE = (360, 260)
MISSION = f"/api/v1/robots/{ROBOT}/mission.geojson"


@pytest.fixture(scope="session")
def map_server() -> Iterator[MapServer]:
    server = MapServer()
    yield server
    server.close()


@pytest.fixture
def server(map_server: MapServer) -> MapServer:
    map_server.json("/api/v1/features", map_field.farm())
    map_server.json(MISSION, map_field.mission())
    map_server.requests.clear()
    return map_server


@pytest.fixture
def the_map(page: Page, server: MapServer) -> MapPage:
    page.set_viewport_size(SIZE)
    return MapPage(page, server)


def offset_m(lon: float, lat: float, east: float, north: float) -> tuple[float, float]:
    """Return the point so many metres east and north."""
    return lon + east / (111_320 * math.cos(math.radians(lat))), lat + north / 111_200


@pytest.mark.parametrize("engine", ENGINES)
def test_the_robot_is_drawn_where_it_says_it_is_and_the_map_follows(the_map: MapPage, engine: str) -> None:
    the_map.open(engine=engine)
    lon, lat = the_map.on_row()
    x, y = the_map.place(lon, lat)
    assert (x, y) == pytest.approx(CENTRE, abs=1.0)
    entry = the_map.page.get_by_test_id(f"map-robot-{ROBOT}")
    expect(entry).to_have_attribute("data-lat", str(lat))
    expect(entry).to_have_attribute("data-lon", str(lon))
    expect(the_map.page.get_by_test_id("map")).to_have_attribute("data-robots", "1")
    pixels = the_map.pixels()
    around = [pixels.at(x + 7 * math.cos(a), y + 7 * math.sin(a)) for a in (0.6, 2.4, 3.9, 5.5)]
    assert any(is_close(seen, the_map.token("--hl-sel")) for seen in around)
    assert the_map.problems == []


@pytest.mark.long
def test_farm_and_robot_layers_agree_on_where_the_ground_is(the_map: MapPage) -> None:
    the_map.open()
    corner = map_field.farm()["features"][0]["geometry"]["coordinates"][0][5]
    the_map.describe_robot()
    the_map.pose(*corner)
    the_map.settle()
    the_map.page.evaluate("map.engine.jump({ zoom: 19, bearing: 30 })")
    the_map.settle()
    ring = map_field.farm()["features"][0]["geometry"]["coordinates"][0]
    other = ring[6]
    share = 30 / math.dist(map_field.to_m(*corner), map_field.to_m(*other))
    mark = [corner[i] + (other[i] - corner[i]) * share for i in (0, 1)]
    x, y = the_map.place(*mark)
    pixels = the_map.pixels()
    edge = the_map.token("--hl-m-edge")
    assert any(is_close(pixels.at(x + dx, y + dy), edge, 40) for dx in (-1, 0, 1) for dy in (-1, 0, 1))


@pytest.mark.long
@pytest.mark.parametrize("engine", ENGINES)
def test_done_rows_are_dark_the_current_one_heavy_the_next_dashed_and_the_rest_thin(
    the_map: MapPage, engine: str
) -> None:
    the_map.open(engine=engine)
    the_map.on_row(share=0.5)
    the_map.hide_names()
    pixels = the_map.pixels()
    done, path, bed = (the_map.token(f"--hl-m-{name}") for name in ("done", "path", "parcel-on"))
    assert the_map.share_of(pixels, done, along_row(ROW - 2, 0.4, 0.6)) > 0.9
    assert the_map.share_of(pixels, path, along_row(ROW, 0.53, 0.66)) > 0.9
    assert 0.4 < the_map.share_of(pixels, path, along_row(ROW + 1, 0.4, 0.6)) < 0.85
    assert the_map.share_of(pixels, path, along_row(ROW + 6, 0.4, 0.6)) == 0
    between = [offset_m(*point, 0.6, 2.4) for point in along_row(ROW + 6, 0.4, 0.6)]
    assert the_map.share_of(pixels, bed, between) > 0.9


@pytest.mark.long
@pytest.mark.parametrize("engine", ENGINES)
def test_a_silent_robot_becomes_a_hollow_ghost_that_stays_where_it_was_seen(the_map: MapPage, engine: str) -> None:
    the_map.open(engine=engine)
    lon, lat = the_map.on_row()
    entry = the_map.page.get_by_test_id(f"map-robot-{ROBOT}")
    expect(entry).to_have_attribute("data-state", "fresh")
    the_map.page.evaluate("lane.pass(12000)")
    expect(entry).to_have_attribute("data-state", "stale")
    the_map.settle()
    state = the_map.state()
    [robot] = state["robots"]
    assert (robot["lon"], robot["lat"]) == (lon, lat)
    assert robot["reachM"] == pytest.approx(0.4 * 12)
    assert any(text.startswith("last seen ") for text in state["texts"])
    assert "within 4.8 m if it kept going" in state["texts"]
    x, y = the_map.place(lon, lat)
    pixels = the_map.pixels()
    inside = [pixels.at(x + dx, y + dy) for dx in range(-9, 10) for dy in range(-9, 10)]
    assert sum(is_close(c, the_map.token("--hl-raised"), 6) for c in inside) > 60
    assert not any(is_close(c, the_map.token("--hl-sel"), 6) for c in inside[150:210])


def test_a_robot_is_never_drawn_ahead_of_its_newest_pose(the_map: MapPage) -> None:
    the_map.open()
    the_map.describe_robot()
    for i in range(4):
        lon, lat, heading = map_field.row_point(ROW, 0.4 + i / 400)
        the_map.pose(lon, lat, heading, 1.6)
    places = the_map.page.evaluate(
        """() => {
            const robot = map.intake.selected;
            const late = robot.drawn(performance.now() + 60000);
            const early = robot.drawn(robot.arrived + robot.span / 2);
            return [late.mx - robot.pose.mx, late.my - robot.pose.my, early.mx <= robot.pose.mx];
        }"""
    )
    assert places[:2] == [0, 0]
    assert places[2]


@pytest.mark.long
@pytest.mark.parametrize("engine", ENGINES)
def test_an_unconfirmed_stop_shows_the_keep_out_ring_and_how_far_the_robot_can_be(
    the_map: MapPage, engine: str
) -> None:
    the_map.open(engine=engine)
    lon, lat = the_map.on_row()
    the_map.page.evaluate("lane.pass(8000)")
    the_map.page.evaluate(
        """(robot) => {
            const detail = { steps: [{ robot, state: 'acknowledged' }, { robot, state: 'not-confirmed' }] };
            dispatchEvent(new CustomEvent('headland:stop', { detail }));
        }""",
        ROBOT,
    )
    the_map.settle()
    state = the_map.state()
    assert state["robots"][0]["stop"] == "not-confirmed"
    assert "keep out 15 m" in state["texts"]
    assert "may be here, within 3.2 m" in state["texts"]
    pixels = the_map.pixels()
    x, y = the_map.place(lon, lat)
    red = the_map.token("--hl-p1")
    radius = 15 / state["camera"]["metresPerPx"]
    assert 60 < radius < 250, "the ring fills the map"

    def on_ring(px: float) -> float:
        hits = 0
        for i in range(180):
            a = i / 90 * math.pi
            spots = [(x + (px + d) * math.cos(a), y + (px + d) * math.sin(a)) for d in (-1, 0, 1)]
            hits += any(is_close(pixels.at(*spot), red, 60) for spot in spots)
        return hits / 180

    assert 0.35 < on_ring(radius) < 0.85
    assert on_ring(state["robots"][0]["reachM"] / state["camera"]["metresPerPx"]) > 0.9


def test_a_confirmed_stop_puts_a_yellow_octagon_around_the_robot_until_it_is_reset(the_map: MapPage) -> None:
    the_map.open()
    lon, lat = the_map.on_row()
    x, y = the_map.place(lon, lat)
    before = the_map.pixels().at(x + 2, y - 33)
    the_map.put(safety={"t": 0, "latched": True, "standstill": True, "presses": []})
    the_map.settle()
    assert the_map.state()["robots"][0]["stop"] == "stopped"
    red, green, blue = the_map.pixels().at(x + 2, y - 33)
    assert red - blue > 60, "yellow"
    assert green > blue
    the_map.put(safety={"t": 1, "latched": False, "standstill": True, "presses": []})
    the_map.settle()
    assert is_close(the_map.pixels().at(x + 2, y - 33), before)


def test_a_robot_that_reports_a_latched_stop_but_moves_is_not_shown_as_stopped(the_map: MapPage) -> None:
    the_map.open()
    the_map.on_row()
    the_map.put(safety={"t": 0, "latched": True, "standstill": False, "presses": []})
    the_map.settle()
    assert the_map.state()["robots"][0]["stop"] is None


@pytest.mark.long
def test_the_map_changes_its_colours_with_the_theme(the_map: MapPage) -> None:
    the_map.open()
    the_map.on_row()
    the_map.hide_names()
    seen = []
    for theme in ("day", "night", "sunlight"):
        the_map.page.evaluate("(theme) => { document.documentElement.dataset.theme = theme; }", theme)
        the_map.settle()
        pixels = the_map.pixels()
        done = the_map.token("--hl-m-done")
        assert the_map.share_of(pixels, done, along_row(ROW - 2, 0.45, 0.6)) > 0.9, theme
        x, y = the_map.place(*offset_m(*map_field.row_point(1, 0.5)[:2], -300, -300))
        seen.append(done)
        assert x < 0 or y < 0 or is_close(pixels.at(x, y), the_map.token("--hl-m-ground"))
    assert len(set(seen)) == 3


@pytest.mark.long
def test_without_webgl_the_same_map_comes_from_a_canvas_and_says_so(
    browser_type: BrowserType, browser_type_launch_args: dict[str, Any], server: MapServer
) -> None:
    launch = {**browser_type_launch_args, "args": [*browser_type_launch_args["args"], "--disable-3d-apis"]}
    browser: Browser = browser_type.launch(**launch)
    try:
        the_map = MapPage(browser.new_page(viewport=SIZE), server)
        the_map.open()
        _, lat = the_map.on_row()
        assert the_map.state()["engine"] == "canvas"
        expect(the_map.page.get_by_test_id("map-notice")).to_contain_text("no WebGL")
        expect(the_map.page.get_by_test_id(f"map-robot-{ROBOT}")).to_have_attribute("data-lat", str(lat))
        assert not any("maplibre-gl.mjs" in url for url in the_map.urls), "nothing is loaded that cannot run"
    finally:
        browser.close()


def test_a_map_that_shall_be_quick_is_not_drawn_by_webgl_in_software(the_map: MapPage) -> None:
    the_map.open(engine="quick")
    the_map.on_row()
    assert the_map.state()["engine"] == "canvas"
    expect(the_map.page.get_by_test_id("map-notice")).not_to_contain_text("Simple map")
    assert not any("maplibre-gl.mjs" in url for url in the_map.urls), "nothing is loaded that is not used"


@pytest.mark.long
def test_graphics_that_fail_while_running_are_replaced_by_the_canvas(the_map: MapPage) -> None:
    the_map.open()
    lon, lat = the_map.on_row()
    before = the_map.state()["camera"]["zoom"]
    the_map.page.evaluate("map.engine.map.painter.context.gl.getExtension('WEBGL_lose_context').loseContext()")
    the_map.page.wait_for_function("map.engine?.kind === 'canvas'")
    the_map.settle()
    assert the_map.state()["camera"]["zoom"] == before
    assert the_map.place(lon, lat) == pytest.approx(CENTRE, abs=1.0)
    expect(the_map.page.get_by_test_id("map-notice")).to_contain_text("Simple map")


@pytest.mark.long
def test_graphics_that_come_back_go_on_and_those_of_robots_alone_are_replaced_too(the_map: MapPage) -> None:
    the_map.open()
    the_map.on_row()
    lose = (
        "window.lost = document.querySelector('.hl-map-scene').getContext('webgl2').getExtension('WEBGL_lose_context')"
    )
    the_map.page.evaluate(f"({lose}).loseContext()")
    the_map.page.wait_for_function("map.engine.gone.size === 1")
    the_map.page.evaluate("lost.restoreContext()")
    the_map.page.wait_for_function("map.engine.gone.size === 0")
    the_map.settle()
    assert the_map.state()["engine"] == "gl"
    the_map.page.evaluate("lost.loseContext()")
    the_map.page.wait_for_function("map.engine?.kind === 'canvas'")


@pytest.mark.long
def test_nothing_is_asked_of_another_origin(the_map: MapPage) -> None:
    the_map.open()
    the_map.on_row()
    the_map.page.get_by_test_id("map-zoom-out").click()
    the_map.settle()
    assert any(url.endswith("/static/vendor/maplibre/maplibre-gl-worker.mjs") for url in the_map.urls)
    foreign = [url for url in the_map.urls if not url.startswith((the_map.server.origin, "data:", "blob:"))]
    assert foreign == []
    assert the_map.problems == []


@pytest.mark.long
@pytest.mark.parametrize("engine", ENGINES)
def test_panning_ends_following_and_the_button_takes_it_up_again(the_map: MapPage, engine: str) -> None:
    the_map.open(engine=engine)
    the_map.on_row()
    follow = the_map.page.get_by_test_id("map-follow")
    expect(follow).to_have_attribute("aria-pressed", "true")
    the_map.page.mouse.move(250, 400)
    the_map.page.mouse.down()
    the_map.page.mouse.move(370, 330, steps=6)
    the_map.page.mouse.up()
    expect(follow).to_have_attribute("aria-pressed", "false")
    lon, lat, heading = map_field.row_point(ROW, 0.42)
    the_map.pose(lon, lat, heading)
    the_map.settle()
    assert math.dist(the_map.place(lon, lat), CENTRE) > 60
    follow.click()
    the_map.settle()
    assert the_map.place(lon, lat) == pytest.approx(CENTRE, abs=1.0)


@pytest.mark.long
def test_controls_are_large_enough_for_gloves_and_zoom(the_map: MapPage) -> None:
    the_map.open()
    the_map.on_row()
    for name in ("follow", "layers", "zoom-in", "zoom-out", "north"):
        box = the_map.page.get_by_test_id(f"map-{name}").bounding_box()
        assert box is not None
        assert min(box["width"], box["height"]) >= (48 if name == "north" else 56)
    before = the_map.state()["camera"]["zoom"]
    the_map.page.get_by_test_id("map-zoom-in").click()
    the_map.page.wait_for_function("(zoom) => headlandMap.state().camera.zoom > zoom + 0.9", arg=before)


@pytest.mark.long
def test_hidden_layers_stay_hidden_after_a_reload(the_map: MapPage) -> None:
    the_map.open()
    the_map.on_row(share=0.5)
    the_map.page.get_by_test_id("map-layers").click()
    the_map.page.get_by_test_id("map-layer-rows").uncheck()
    the_map.open()
    the_map.on_row(share=0.5)
    done = the_map.token("--hl-m-done")
    assert the_map.share_of(the_map.pixels(), done, along_row(ROW - 2, 0.4, 0.6)) < 0.1


@pytest.mark.long
def test_the_mission_is_fetched_again_only_when_its_hash_changes(the_map: MapPage) -> None:
    the_map.open()
    the_map.on_row()
    the_map.on_row(share=0.45)
    assert the_map.server.requests.count(MISSION) == 1
    the_map.describe_robot(sha="b" * 64)
    the_map.page.wait_for_function("map.intake.missionState === 'loaded'")
    assert the_map.server.requests.count(MISSION) == 2


@pytest.mark.long
def test_a_map_that_did_not_load_says_so_and_tries_again(the_map: MapPage) -> None:
    the_map.server.json("/api/v1/features", {"code": "down"}, status=503)
    the_map.page.goto(the_map.server.page("/page", robotId=ROBOT))
    notice = the_map.page.get_by_test_id("map-notice")
    expect(notice).to_contain_text("Map did not load")
    asked = the_map.server.requests.count("/api/v1/features")
    notice.get_by_role("button", name="Try again").click()
    the_map.server.json("/api/v1/features", map_field.farm())
    expect(notice).to_contain_text(f"No position from {ROBOT} yet")
    assert the_map.server.requests.count("/api/v1/features") > asked
    the_map.on_row()
    expect(notice).to_be_hidden()


@pytest.mark.long
def test_one_broken_feature_does_not_take_the_map_with_it(the_map: MapPage) -> None:
    farm = map_field.farm()
    farm["features"][3:3] = [
        {"type": "Feature", "properties": {"kind": "road"}, "geometry": None},
        {"type": "Feature", "properties": {"kind": "parcel"}, "geometry": {"type": "Polygon", "coordinates": [[]]}},
        {"type": "Feature", "properties": {"kind": "tree"}, "geometry": {"type": "Point", "coordinates": ["a", 1]}},
    ]
    the_map.server.json("/api/v1/features", farm)
    the_map.open()
    the_map.on_row()
    assert "Nordfeld 12" in the_map.state()["texts"]
    assert "sugar beet, 17.26 ha" in the_map.state()["texts"]


@pytest.mark.long
def test_a_console_that_restarts_its_clock_does_not_freeze_the_robot(the_map: MapPage) -> None:
    the_map.open()
    the_map.on_row()
    the_map.page.evaluate("lane.pass(-1e7); lane.put('hello', { boot: 'another' })")
    lon, lat, heading = map_field.row_point(ROW, 0.6)
    the_map.pose(lon, lat, heading)
    expect(the_map.page.get_by_test_id(f"map-robot-{ROBOT}")).to_have_attribute("data-lat", str(lat))


def test_a_fleet_is_drawn_whole_and_a_tap_chooses_a_robot(the_map: MapPage) -> None:
    the_map.open(mode="fleet", robotId=None)
    now = the_map.page.evaluate("headland.now()")
    robots, places = {}, {}
    for i in range(300):
        lon, lat, heading = map_field.row_point(1 + i % 60, 0.1 + 0.8 * (i // 60) / 5)
        robots[f"r-{i}"] = {"name": f"R{i}", "family": "weeder"}
        places[f"r-{i}"] = {"t": now, "lon": lon, "lat": lat, "heading_deg": heading}
    robots["r-7"] |= {"level": 1, "text": "not confirmed"}
    the_map.put("fleet", robots=robots)
    the_map.put("poses", robots=places)
    expect(the_map.page.get_by_test_id("map")).to_have_attribute("data-robots", "300")
    the_map.settle()
    clusters = the_map.page.evaluate("map.fleet.clusters.map((one) => [one.ids.includes('r-7'), one.level])")
    assert [True, 1] in clusters  # robots that lie on each other are one disc, which carries the worst sign
    the_map.page.evaluate(
        "(() => { const { mx, my } = map.intake.robots.get('r-7').pose; map.engine.jump({ mx, my, zoom: 21 }) })()"
    )
    the_map.page.wait_for_function("!map.fleet.clusters.some((one) => one.ids.includes('r-7'))")
    the_map.settle()
    assert "R7 not confirmed" in the_map.state()["texts"]
    chosen = places["r-7"]
    x, y = the_map.place(chosen["lon"], chosen["lat"])
    the_map.page.mouse.click(x, y)
    the_map.page.wait_for_function("window.selected.length === 1")
    assert the_map.page.evaluate("window.selected") == ["r-7"]
    moved = {"r-7": {"t": now + 50, "lon": chosen["lon"] + 0.0005, "lat": chosen["lat"], "heading_deg": 0}}
    the_map.put("poses", robots=moved)
    the_map.settle()
    assert the_map.page.evaluate("map.intake.robots.get('r-7').pose.lon") == chosen["lon"] + 0.0005


@pytest.mark.long
def test_figures_for_people_are_rounded_up_and_trails_do_not_cross_gaps(the_map: MapPage) -> None:
    the_map.open()
    texts = the_map.page.evaluate(
        """async () => {
            const { upTo } = await import('/static/js/map/robots.js');
            return [0.01, 3.36, 5, 5.04, 14.2, 15].map(upTo);
        }"""
    )
    assert texts == ["0.1 m", "3.4 m", "5 m", "5.1 m", "15 m", "15 m"]
    lengths = the_map.page.evaluate(
        """async () => {
            const { Trail } = await import('/static/js/map/trail.js');
            const { mercPerMetre } = await import('/static/js/map/geometry.js');
            const m = mercPerMetre(0.33);
            const trail = new Trail();
            for (let i = 0; i < 12000; i += 1) trail.add({ mx: 0.5 + i * m, my: 0.33 }, i === 6000);
            trail.add({ mx: 0.5, my: 0.33 }, false);
            const origin = { mx: 0.5, my: 0.33 };
            const sets = trail.sets(origin);
            const longest = Math.max(...sets.map((set) => {
                const step = (i) => Math.abs(set.data[i * 5 + 2] - set.data[i * 5]) / m;
                return Math.max(0, ...Array.from({ length: set.count }, (_, i) => step(i)));
            }));
            return [sets.length, longest];
        }"""
    )
    assert lengths[0] <= 40
    assert lengths[1] < 1.5


@pytest.mark.long
def test_body_of_the_robot_is_drawn_to_scale_when_near(the_map: MapPage) -> None:
    the_map.open()
    lon, lat, _ = map_field.row_point(ROW, 0.5)
    the_map.describe_robot()
    the_map.pose(lon, lat, 0.0, 0.0)
    the_map.settle()
    the_map.page.evaluate("map.engine.jump({ zoom: 21 })")
    the_map.settle()
    pixels = the_map.pixels()
    x, y = the_map.place(lon, lat)
    body = the_map.token("--hl-sel")
    per_metre = 1 / the_map.state()["camera"]["metresPerPx"]
    column = [y + dy for dy in range(-200, 200) if is_close(pixels.at(x + 0.5 * per_metre, y + dy), body)]
    length = (max(column) - min(column)) / per_metre
    assert length == pytest.approx(BODY["length_m"], abs=0.1)
