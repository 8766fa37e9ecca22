"""The Plan screen in a browser; REST is played by the test."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from typing import Any

import pytest
import shapely
from playwright.sync_api import Page, Route, expect

from hmi.domain.mission_plan import Pattern, RowLine, Rows
from hmi.planning.mission import plan_candidate
from tests.hmi.missions.rig import lon_lat
from tests.hmi.missions.test_document import wish
from tests.hmi.pages.test_missions import Played, mission
from tests.hmi.pages.test_rest_sheet import drag_around

Look = Callable[..., Page]
AREA = {
    "id": "wet-1",
    "name": "Wet corner",
    "kind": "treatment",
    "properties": {"dose": 0.5},
    "geometry": {"type": "Polygon", "coordinates": wish().parcel["coordinates"]},
}


class PlayedPlans(Played):
    """REST with candidates that differ, one of them refused, and templates."""

    def __init__(self, page: Page) -> None:
        super().__init__(page, [mission("m-1")])
        self.templates: list[dict[str, Any]] = []
        self.candidates = self.lines()
        page.route("**/api/v1/plan-templates**", self.template)
        page.route("**/api/v1/missions/candidates", self.compare)

    @staticmethod
    def lines(**changes: Any) -> list[dict[str, Any]]:
        """Return what the server streams."""
        found: list[dict[str, Any]] = [{"state": "planning", "patterns": [one.value for one in Pattern]}]
        for pattern in (Pattern.SHORTEST, Pattern.ROW_BY_ROW, Pattern.SKIP_ROWS):
            made = plan_candidate(wish(pattern=pattern, **changes))
            line = {"pattern": pattern.value, "statistics": made.statistics, "drawing": made.drawing}
            found.append({**line, "state": "planned"})
        refusal = {"state": "refused", "code": "turn_does_not_fit", "text": "The turn does not fit.", "field": None}
        return [*found, {"pattern": "spiral", **refusal}, {"state": "done"}]

    def compare(self, route: Route) -> None:
        """Stream the candidates."""
        self.asked.append(("POST", "missions/candidates", json.loads(route.request.post_data or "{}")))
        body = "".join(json.dumps(line) + "\n" for line in self.candidates)
        route.fulfill(status=200, content_type="application/x-ndjson", body=body)

    def template(self, route: Route) -> None:
        """Keep templates."""
        if route.request.method == "POST":
            body = json.loads(route.request.post_data or "{}")
            self.templates.append({"id": f"t-{len(self.templates)}", **body})
        route.fulfill(status=200, content_type="application/json", body=json.dumps({"templates": self.templates}))

    def reply(self, method: str, path: str) -> tuple[int, Any]:
        """Answer as usual, the field with its outline."""
        if path == "fields" and self.status == 200:
            lines = {"guide_line": 1, "recorded_rows": 24}
            field = {
                "id": "field-1",
                "name": "Nordfeld 12",
                "properties": {},
                "geometry": wish().parcel,
                "lines": lines,
            }
            return 200, {"fields": [field], "homes": [], "areas": [AREA]}
        return super().reply(method, path)


@pytest.fixture
def plan(look: Look) -> Callable[..., tuple[Page, PlayedPlans]]:
    """Open the Plan screen."""

    def open_screen(size: str = "landscape") -> tuple[Page, PlayedPlans]:
        page = look("/operate", role="supervisor", size=size)
        played = PlayedPlans(page)
        page.get_by_test_id("nav-missions").click()
        page.get_by_test_id("mission-plan").click()
        expect(page.get_by_test_id("plan-width")).to_be_visible()
        return page, played

    return open_screen


def value(page: Page, hook: str) -> float:
    """Return the machine-readable value of a hook."""
    return float(page.get_by_test_id(hook).get_attribute("data-value") or "nan")


def test_row_orders_are_compared_and_the_tapped_one_is_stored_and_sent(
    plan: Callable[..., tuple[Page, PlayedPlans]],
) -> None:
    page, played = plan()
    page.get_by_test_id("plan-preview").click()
    expect(page.get_by_test_id("plan-compare-skip_rows")).to_have_attribute("data-state", "planned")
    expect(page.get_by_test_id("plan-compare-spiral")).to_contain_text("The turn does not fit.")
    shortest = value(page, "plan-stat-length")
    page.get_by_test_id("plan-compare-skip_rows").get_by_role("button").click()
    expect(page.get_by_test_id("plan-compare-skip_rows")).to_have_attribute("aria-current", "true")
    assert value(page, "plan-stat-length") != shortest
    page.get_by_test_id("plan-send").click()
    expect(page.get_by_test_id("toast")).to_contain_text("It does not move yet.")
    assert [(path, body.get("pattern")) for _, path, body in played.asked if path.startswith("missions")] == [
        ("missions/candidates", None),
        ("missions/plan", "skip_rows"),
    ]


def test_what_can_be_done_with_a_plan_stands_in_one_line(plan: Callable[..., tuple[Page, PlayedPlans]]) -> None:
    page, _ = plan("portrait")
    page.evaluate("HL.preferences.set('theme', 'sunlight')")  # its letters are the largest
    page.get_by_test_id("plan-preview").click()
    expect(page.get_by_test_id("plan-compare-shortest")).to_have_attribute("data-state", "planned")
    hooks = ("plan-send", "plan-store", "plan-queue", "plan-template")
    tops = {round(box["y"]) for hook in hooks if (box := page.get_by_test_id(hook).bounding_box())}
    assert len(tops) == 1


@pytest.mark.parametrize("hook", ["missions-tab-list", "missions-tab-plan"])
def test_changes_of_a_draft_are_asked_about_wherever_its_form_is_left_to(look: Look, hook: str) -> None:
    page = look("/operate", role="supervisor", size="landscape")
    played = PlayedPlans(page)
    played.missions = [mission("m-1", "draft", wish={"width_m": 3}, revision=1, name="Beans", statistics={}, sha256="")]
    page.get_by_test_id("nav-missions").click()
    page.get_by_test_id("draft-open").click()
    page.get_by_test_id("plan-width").fill("4")
    page.get_by_test_id(hook).click()
    expect(page.get_by_test_id("draft-leave")).to_contain_text("Beans was changed and not saved.")
    page.get_by_test_id("draft-leave").get_by_role("button", name="Leave them").click()
    title = page.get_by_test_id("plan-title")
    expect(title).to_have_count(0) if hook == "missions-tab-list" else expect(title).to_have_text("Plan a mission")


@pytest.mark.parametrize(("name", "own"), [("Nordfeld 12", ""), ("Before the rain", "Before the rain")])
def test_a_draft_called_after_its_field_follows_the_field(look: Look, name: str, own: str) -> None:
    page = look("/operate", role="supervisor", size="landscape")
    played = PlayedPlans(page)
    kept = mission("m-1", "draft", wish={"field_id": "field-1"}, revision=1, name=name, statistics={}, sha256="")
    played.missions = [kept]
    page.get_by_test_id("nav-missions").click()
    page.get_by_test_id("draft-open").click()
    expect(page.get_by_test_id("plan-field")).to_have_value("field-1")
    expect(page.locator("[data-testid=plan-name]")).to_have_value(own)


def test_an_answer_about_a_draft_that_was_left_does_not_take_the_form_that_is_open_now(look: Look) -> None:
    page = look("/operate", role="supervisor", size="landscape")
    played = PlayedPlans(page)
    waiting: list[Route] = []
    page.route("**/api/v1/missions/drafts", lambda route: waiting.append(route))
    page.get_by_test_id("nav-missions").click()
    page.get_by_test_id("mission-plan").click()
    page.get_by_test_id("plan-draft").click()
    expect(page.get_by_test_id("plan-draft")).to_be_disabled()
    page.get_by_test_id("missions-tab-plan").click()
    expect(page.get_by_test_id("plan-draft")).to_be_enabled()
    kept = mission("m-2", "draft", wish={}, revision=1, name="Beans", statistics={}, sha256="")
    played.missions = [kept, *played.missions]
    waiting[0].fulfill(status=201, content_type="application/json", body=json.dumps(kept))
    expect(page.get_by_test_id("toast")).to_contain_text("Beans is kept as a draft")
    expect(page.get_by_test_id("plan-title")).to_have_text("Plan a mission")


OFFERED = """() => {
  const ring = (lon) => [[lon, 52], [lon + 0.002, 52], [lon + 0.002, 52.002], [lon, 52.002], [lon, 52]];
  const field = ([id, lon]) => ({
    id, name: id, properties: {}, geometry: { type: "Polygon", coordinates: [ring(lon)] },
  });
  const fields = [["a", 5], ["b", 5.004], ["c", 6]].map(field);
  const lons = { "on-b": 5.005, "by-a": 4.999, "on-c": 6.001 };
  const robots = Object.keys(lons).map((id) => ({ id, name: id }));
  HL.port.fleet = () => Object.fromEntries(Object.entries(lons).map(([id, lon]) => [id, { lon, lat: 52.001 }]));
  const inputs = new HL.planner.Inputs({ fields, homes: [], robots });
  inputs.isKept = false;
  const offered = (robot) => {
    inputs.get("robot_id").value = robot;
    inputs.offerField();
    return inputs.get("field_id").value;
  };
  const first = ["on-b", "by-a"].map(offered);
  inputs.isFieldChosen = true;
  return [...first, offered("on-b"), offered("on-c")];
}"""


def test_the_field_where_the_robot_stands_is_offered_until_somebody_chooses_one(
    plan: Callable[..., tuple[Page, PlayedPlans]],
) -> None:
    page, _ = plan()
    # the last: a field that somebody chose on another site is of no use to the robot
    assert page.evaluate(OFFERED) == ["b", "a", "a", "c"]


@pytest.mark.long
def test_a_home_without_a_way_can_be_left_out_with_one_tap(plan: Callable[..., tuple[Page, PlayedPlans]]) -> None:
    page, played = plan()
    good = played.candidates
    no_way = {"code": "home_unreachable", "text": "No known way leads from home to this field.", "field": "home_id"}
    lines = [{"pattern": one.value, "state": "refused", **no_way} for one in Pattern]
    first = Pattern.ROW_BY_ROW.value  # the first line of the table
    played.candidates = [good[0], *lines, good[-1]]
    page.get_by_test_id("plan-preview").click()
    expect(page.get_by_test_id("plan-error")).to_have_text("No known way leads from home to this field.")
    expect(page.get_by_test_id("plan-start-at-field")).to_be_visible()
    compare = page.locator(".p-compare")
    expect(compare.get_by_text("No known way leads")).to_have_count(1)
    expect(page.get_by_test_id(f"plan-compare-{first}")).to_contain_text("No known way leads")
    expect(compare.get_by_text("for the same reason")).to_have_count(3)
    played.candidates = good
    page.get_by_test_id("plan-start-at-field").click()
    expect(page.get_by_test_id("plan-compare-shortest")).to_have_attribute("data-state", "planned")
    expect(page.get_by_test_id("plan-start-at-field")).to_be_hidden()
    expect(page.get_by_test_id("plan-return")).to_be_disabled()
    page.get_by_test_id("plan-store").click()
    stored = next(body for _, path, body in played.asked if path == "missions/plan")
    assert (stored["starts_at"], stored["returns_home"], "home_id" in stored) == ("field", False, False)


def planned_at(where: str, text: str) -> dict[str, Any]:
    """Return what a plan says of where it was made."""
    return {"planned_at": {"where": where, "text": text}}


@pytest.mark.long
def test_a_plan_says_where_it_was_made_and_a_planner_service_how_far_it_is(
    plan: Callable[..., tuple[Page, PlayedPlans]],
) -> None:
    page, played = plan()
    first, shortest, *others = played.candidates
    step = {"pattern": "shortest", "state": "progress", "share": 0.43, "text": "Row 12 of 28"}
    words = page.evaluate("(step) => HL.planner.planningWords('shortest', 0, 1, step)", step)
    assert words == "Shortest: Row 12 of 28, 43 %"
    text = "Planned on this server: the planner service did not answer in 5 s."
    shortest["statistics"] |= planned_at("here", text)
    others[0]["statistics"] |= planned_at("service", "Planned by the planner service in 3.2 s, checked here.")
    played.candidates = [first, step, shortest, *others]
    page.get_by_test_id("plan-preview").click()
    expect(page.get_by_test_id("plan-place")).to_have_text(f"cloud_off{text}")
    expect(page.get_by_test_id("plan-place")).to_have_attribute("data-where", "here")
    page.get_by_test_id("plan-compare-row_by_row").get_by_role("button").click()
    expect(page.get_by_test_id("plan-place")).to_have_attribute("data-where", "service")
    expect(page.get_by_test_id("plan-progress")).to_have_text("")


GUIDE = RowLine("Bend", tuple((lon, lat) for lon, lat in lon_lat((-2, 14), (12, 19), (28, 19), (42, 14))))


@pytest.mark.long
@pytest.mark.parametrize("size", ["landscape", "portrait", "desk"])
def test_rows_follow_a_line_that_the_field_has(plan: Callable[..., tuple[Page, PlayedPlans]], size: str) -> None:
    page, played = plan(size)
    played.candidates = played.lines(rows=Rows.GUIDE_LINE, row_lines=(GUIDE,))
    rows, bearing = page.get_by_test_id("plan-rows-along"), page.get_by_test_id("plan-bearing")
    expect(rows.locator("option")).to_have_text(
        ["As planted", "Best angle", "Along the edge", "Guide line", "Recorded rows (24)"]
    )
    bearing.fill("12")
    rows.select_option("guide_line")
    expect(bearing).to_be_hidden()
    page.get_by_test_id("plan-preview").click()
    expect(page.get_by_test_id("plan-stat-length")).to_contain_text("along the guide line")
    expect(page.get_by_test_id("plan-lines")).to_have_attribute("d", re.compile("^M.*L"))
    asked = next(body for _, path, body in played.asked if path == "missions/candidates")
    assert asked["rows"] == "guide_line"
    assert "row_bearing_deg" not in asked
    rows_of_reload = page.evaluate("HL.draft.get('mission-plan').rows")
    assert rows_of_reload == "guide_line"


@pytest.mark.long
def test_the_robot_travels_along_the_plan_by_keys_and_looks_along_its_row(
    plan: Callable[..., tuple[Page, PlayedPlans]],
) -> None:
    page, played = plan()
    page.get_by_test_id("plan-preview").click()
    page.get_by_test_id("plan-scrubber").focus()
    page.keyboard.press("End")
    duration = next(one for one in played.candidates if one.get("pattern") == "shortest")["statistics"]["duration_s"]
    assert float(page.locator(".p-scrub").get_attribute("data-value") or 0) == pytest.approx(duration, abs=2)
    page.keyboard.press("Home")
    expect(page.get_by_test_id("plan-when")).to_have_text(re.compile(r"^Preview 0:00 of \d+:\d\d (h|min), row 1$"))
    page.keyboard.press("ArrowRight")
    legs = next(one for one in played.candidates if one.get("pattern") == "shortest")["drawing"]["legs"]
    (ax, ay, bx, by), outline = legs[0]["xy"][:4], page.get_by_test_id("plan-robot-outline")
    heading = page.evaluate("([x, y]) => Math.atan2(y, x) * 180 / Math.PI", [bx - ax, by - ay])
    assert float(outline.get_attribute("data-heading-deg") or "nan") == pytest.approx(heading, abs=1)
    page.get_by_test_id("plan-play").click()
    expect(page.locator(".p-scrub")).to_have_attribute("data-state", "playing")


@pytest.mark.long
def test_a_picture_that_was_zoomed_comes_along_with_the_robot(plan: Callable[..., tuple[Page, PlayedPlans]]) -> None:
    page, _ = plan()
    page.get_by_test_id("plan-preview").click()
    page.get_by_test_id("plan-scrubber").focus()
    for _ in range(5):
        page.get_by_role("button", name="Zoom in").click()
    page.get_by_test_id("plan-scrubber").focus()
    for key in ("End", "Home"):
        page.keyboard.press(key)
        robot = page.get_by_test_id("plan-robot-outline").bounding_box()
        picture = page.locator(".p-picture").bounding_box()
        assert robot is not None
        assert picture is not None
        middle = robot["x"] + robot["width"] / 2, robot["y"] + robot["height"] / 2
        assert picture["x"] < middle[0] < picture["x"] + picture["width"]
        assert picture["y"] < middle[1] < picture["y"] + picture["height"]


@pytest.mark.long
def test_battery_link_and_position_are_looked_at_before_sending(
    plan: Callable[..., tuple[Page, PlayedPlans]],
) -> None:
    page, _ = plan()
    page.get_by_test_id("plan-preview").click()
    expect(page.get_by_test_id("plan-check-link")).to_have_attribute("data-state", "good")
    expect(page.get_by_test_id("plan-check-battery")).to_have_text(re.compile("Battery is enough: 68 % now$"))
    expect(page.get_by_test_id("plan-check-people")).to_have_attribute("data-state", "unknown")


@pytest.mark.long
@pytest.mark.parametrize(
    ("figures", "said"),
    [
        ({"battery_j": 12 * 3.6e6, "charge_w": 3000.0}, "Not enough: needs 85 %, has 68 %. Charge 45 min first."),
        ({"battery_j": 12 * 3.6e6, "charge_w": 1200.0}, "Not enough: needs 85 %, has 68 %. Charge 1 h 45 first."),
        ({"battery_j": 12 * 3.6e6}, "Not enough: needs 85 %, has 68 %. Charge first."),
    ],
)
def test_it_is_said_how_long_to_charge_where_the_robot_says_how_fast_it_charges(
    plan: Callable[..., tuple[Page, PlayedPlans]], figures: dict[str, float], said: str
) -> None:
    page, played = plan()
    for line in played.candidates:
        if "statistics" in line:
            line["statistics"] = {**line["statistics"], "battery_share": 0.7, "reserve_share": 0.15, **figures}
    page.get_by_test_id("plan-preview").click()
    expect(page.get_by_test_id("plan-check-battery")).to_contain_text(said)


def test_an_area_drawn_with_a_finger_belongs_to_this_plan(plan: Callable[..., tuple[Page, PlayedPlans]]) -> None:
    page, played = plan()
    page.get_by_test_id("plan-change-treatment").click()
    page.get_by_test_id("plan-draw-area").click()
    drag_around(page, page.get_by_test_id("plan-picture"), 60)
    page.get_by_test_id("plan-drawn-dose-0").select_option("2")
    page.get_by_test_id("plan-preview").click()
    expect(page.get_by_test_id("plan-stat-turns")).to_be_visible()
    drawn = next(one for one in played.asked[-1][2]["treatments"] if "geometry" in one)
    assert drawn["dose"] == 2
    field = shapely.Polygon(wish().parcel["coordinates"][0])
    outline = shapely.Polygon(drawn["geometry"]["coordinates"][0])
    assert field.contains(outline)
    assert outline.centroid.distance(field.centroid) < 0.1 * field.length
    expect(page.locator(".p-svg .drawn")).to_have_count(1)  # and stays where it is on the plan's own plane


def test_how_the_field_is_treated_outlives_a_reload(plan: Callable[..., tuple[Page, PlayedPlans]]) -> None:
    page, played = plan()
    page.get_by_test_id("plan-change-treatment").click()
    page.get_by_test_id("plan-dose-wet-1").select_option("0")
    page.get_by_test_id("plan-rest-dose").select_option("0.5")
    page.get_by_test_id("plan-lead-in").fill("2")
    page.reload()
    page.get_by_test_id("mission-plan").click()
    page.get_by_test_id("plan-preview").click()
    expect(page.get_by_test_id("plan-stat-turns")).to_be_visible()
    asked = played.asked[-1][2]
    assert (asked["rest_dose"], asked["lead_in_m"], asked["treatments"]) == (
        0.5, 2, [{"feature_id": "wet-1", "dose": 0}]
    )  # fmt: skip


@pytest.mark.long
def test_the_dose_of_a_map_area_is_planned_with_and_can_be_switched_off(
    plan: Callable[..., tuple[Page, PlayedPlans]],
) -> None:
    page, played = plan()
    page.get_by_test_id("plan-change-treatment").click()
    expect(page.get_by_test_id("plan-dose-wet-1")).to_have_value("0.5")
    page.get_by_test_id("plan-dose-wet-1").select_option("0")
    page.get_by_test_id("plan-preview").click()
    expect(page.get_by_test_id("plan-stat-turns")).to_be_visible()
    assert played.asked[-1][2]["treatments"] == [{"feature_id": "wet-1", "dose": 0}]


@pytest.mark.long
def test_a_template_brings_its_choices_back(plan: Callable[..., tuple[Page, PlayedPlans]]) -> None:
    page, _ = plan()
    page.get_by_test_id("plan-width").fill("1.35")
    page.get_by_test_id("plan-template").click()
    page.get_by_test_id("template-name").fill("Beet")
    page.get_by_test_id("dialog").get_by_text("Save", exact=True).click()
    expect(page.get_by_test_id("toast")).to_contain_text("Template Beet is saved")
    page.get_by_test_id("plan-width").fill("3")
    page.get_by_test_id("plan-templates").click()
    page.get_by_test_id("template-t-0").get_by_text("Beet", exact=True).click()
    expect(page.get_by_test_id("plan-width")).to_have_value("1.35")


@pytest.mark.long
@pytest.mark.parametrize("size", ["portrait", "desk"])
def test_every_view_shows_on_every_screen(plan: Callable[..., tuple[Page, PlayedPlans]], size: str) -> None:
    page, _ = plan(size)
    page.get_by_test_id("plan-preview").click()
    for view in ("turns", "overlap", "time", "path"):
        page.get_by_test_id(f"plan-view-{view}").click()
        expect(page.get_by_test_id("plan-picture")).to_have_attribute("data-view", view)
    expect(page.get_by_test_id("plan-send")).to_be_enabled()


QUEUE = {
    "ok": True,
    "now_utc": "2026-05-20T14:36:40.900+00:00",
    "zone": "UTC",
    "frozen": None,
    "weather": None,
    "robots": [{"robot_id": "weeder-07", "name": "Weeder 07", "revision": 1, "is_unattended_allowed": False,
                "arming": None, "disarmed": None, "now": None, "holds": None}],
    "entries": [{"id": "q-1", "robot_id": "weeder-07", "mission_id": "m-9", "name": "Hangacker 5", "status": "queued",
                 "state": "open", "duration_s": 3600, "waiting": None}],
    "ended": [],
    "blackouts": [],
}  # fmt: skip


@pytest.mark.long
def test_on_a_high_screen_the_robots_queue_stands_below_with_the_plan_at_its_end(
    plan: Callable[..., tuple[Page, PlayedPlans]],
) -> None:
    page, _ = plan("landscape")
    expect(page.get_by_test_id("plan-queue-strip")).to_be_hidden()
    page.route("**/api/v1/queue", lambda route: route.fulfill(content_type="application/json", body=json.dumps(QUEUE)))
    page.set_viewport_size({"width": 1920, "height": 1080})
    page.get_by_test_id("plan-preview").click()
    strip = page.get_by_test_id("plan-queue-strip")
    expect(strip.get_by_test_id("queue-bar-q-1")).to_contain_text("Hangacker 5")
    expect(strip.get_by_test_id("queue-bar-this-plan")).to_be_visible()
    queued, planned = (strip.get_by_test_id(f"queue-bar-{one}").bounding_box() for one in ("q-1", "this-plan"))
    assert queued is not None
    assert planned is not None
    assert planned["x"] >= queued["x"] + queued["width"] - 1
    strip.get_by_test_id("plan-queue-open").click()
    expect(page.get_by_test_id("missions")).to_have_attribute("data-tab", "queue")
