"""The console's own styles and scripts, joined into few files whose address carries their hash.

The parts stay small in the source tree; a browser fetches one style sheet and one script, and keeps both for good.
"""

from __future__ import annotations

import hashlib
import re
from functools import cache, partial
from pathlib import Path

from starlette.requests import Request
from starlette.responses import Response
from starlette.routing import Route

STATIC = Path(__file__).resolve().parents[2] / "static"

STYLES = ("tokens", "base", "frame", "panel", "control", "screens", "missions")
"""Cascade order of what every page carries: tokens first, screens last."""

SCREEN_STYLES = (
    "maps", "plan", "queue", "alarms", "fleet", "demo", "supervisor", "twin", "machine_dock", "cameras", "sensors",
    "admin", "small", "forced",
)  # fmt: skip
"""Styles that a screen fetches with its scripts, and those of ``CASE_STYLES``."""
CASE_STYLES = {"small": "(max-width: 899.98px)", "forced": "(forced-colors: active)"}
"""Styles of every page that few windows need, and the media query that says which: no first picture waits for them."""
STYLE_PARTS = {"supervisor": ("supervisor", "supervisor_panels")}
"""A screen's style that is more than one file."""

SCRIPTS = {
    "headland": (
        "core", "glyphs", "words", "preferences", "units", "port", "stops", "sheet",
        "banner", "top_bar", "alarm_counts", "menus", "telemetry_tile", "mission_card", "state_path", "why",
        "slide_to_confirm", "lease", "hold_to_drive", "stop_card", "action_dock",
        "sign_in", "records", "rail", "screen", "keys", "stay_awake",
    ),
    "admin": (
        "alarm_channels", "alarm_notifications", "alarm_limits",
        "admin_robot", "admin_cameras", "admin_cloud", "admin_forms",
    ),
    "bell": ("alarm_order", "alarm_acts", "alarm_tones", "alarm_bell", "alarm_strip", "duty_notice"),
    "alarms": (
        "alarm_words", "alarm_duty", "alarm_rows", "alarm_kpis", "alarm_shelve", "alarm_diagnose", "alarm_detail",
        "alarm_journal", "alarm_statistics", "alarm_filter", "alarm_notes", "alarm_screen",
    ),
    "maps": (
        "maps_kinds", "maps_measure", "maps_queue", "maps_client", "maps_menu", "maps_tools", "maps_hint",
        "maps_fields", "maps_history", "maps_reshape", "maps_export", "maps_import_list", "maps_receiver",
        "maps_feature", "maps_checks", "maps_changes", "maps_cloud", "maps_upload", "maps_base", "maps_import",
        "maps_versions", "maps_publish", "maps_dock", "maps_chips", "maps_recording", "maps_walk", "maps_surface",
        "maps_edits", "maps_screen",
    ),
    "missions": (
        "mission_numbers", "plan_client", "plan_path", "plan_picture", "plan_scrubber", "plan_numbers", "plan_checks",
        "plan_treatment", "plan_steps", "plan_templates", "plan_inputs", "plan_draft", "queue_data", "queue_drag",
        "queue_conditions", "queue_entry", "queue_arm", "queue_blackouts", "queue_timeline", "queue_calendar",
        "queue_list", "queue_view", "plan_queue", "missions_bulk", "mission_form", "mission_ways", "missions",
    ),
    "fleet_ground": ("fleet_order", "fleet_data"),
    "fleet": (
        "fleet_row", "fleet_scroll", "fleet_filter", "fleet_list", "fleet_results",
        "fleet_dock", "fleet_duty", "fleet_menu", "fleet_strip", "fleet_map", "fleet_wall", "fleet_screen",
    ),
    "machine": ("super_base", "jog"),
    "machine_dock": ("super_jog", "super_dock"),
    "supervisor": (
        "super_times", "super_view", "super_chart_facts", "super_chart_draw", "super_chart_layout",
        "super_chart_lists", "super_chart_sheet", "super_chart", "super_gantt_rows", "super_gantt_export",
        "super_gantt", "super_share",
        "super_nodes", "super_logs", "super_node_sheet", "super_functions", "super_screen",
    ),
    "chart_layout": ("chart_placing", "chart_routing", "chart_worker"),
    "twin": (
        "twin_link", "twin_layers", "twin_joints", "twin_replay", "twin_details", "twin_model",
        "twin_alarm", "twin_screen",
    ),
    "camera_door": ("camera/door",),
    "camera": (
        "camera/ways", "camera/sight", "camera/says", "camera/socket", "camera/direct", "camera/viewer", "camera/tile",
        "camera/snapshot", "camera/detections", "camera/gimbal", "camera/pip",
    ),
    "cameras": ("camera/order", "camera/state", "camera/pictures", "camera/wall", "camera/dock"),
    "sensors": (
        "sensor_rules", "sensor_scale", "sensor_units", "sensor_glyphs", "sensor_data", "sensor_gate", "sensor_tiles",
        "sensor_form", "sensor_sheets", "sensor_calibration", "sensor_limits", "sensor_list", "sensor_chart",
        "sensor_curve", "sensor_forecast", "sensor_map", "sensor_values", "sensor_screen",
    ),
    "demo": ("demo_panel",),
    "run": ("field_picture", "start_checks", "rest_sheet", "queue_hold"),
    "draw": ("svg_view", "area_shape", "area_pen", "rest_map"),
}  # fmt: skip
"""Scripts by file, in load order: each uses only names of those before it. Those of another folder than ``ui`` name it.
What few people open loads with its screen; ``bell`` loads on every page, after STOP is ready.
"""

_COMMENT = re.compile(r"\s// [^\"'`]*$")
_CSS_COMMENT = re.compile(r"/\*.*?\*/", re.DOTALL)
_URL = re.compile(r"url\(\.\./([\w./-]+)\)")


def versioned(path: str) -> str:
    """Return the address of a file below ``static`` with the hash of its content, for caching without end.

    Raises:
        FileNotFoundError: there is no such file.
    """
    return f"/static/{path}?v={_digest((STATIC / path).read_bytes())}"


@cache
def style_sheet() -> bytes:
    """Return all styles; the fonts they name carry their hashes."""
    return _styles(STYLES)


@cache
def screen_style(name: str) -> bytes:
    """Return one of ``SCREEN_STYLES``."""
    return _styles(STYLE_PARTS.get(name, (name,)))


def _styles(names: tuple[str, ...]) -> bytes:
    text = "\n".join((STATIC / "css" / f"{name}.css").read_text("utf-8") for name in names)
    lean = _lean(_CSS_COMMENT.sub("", text))
    return _URL.sub(lambda found: f"url({versioned(found[1])})", lean).encode()


@cache
def script(name: str = "headland") -> bytes:
    """Return one of ``SCRIPTS``, joined."""
    return "\n;\n".join(_lean(_source(part).read_text("utf-8")) for part in SCRIPTS[name]).encode()


def _source(part: str) -> Path:
    return STATIC / "js" / (f"{part}.js" if "/" in part else f"ui/{part}.js")


def style_url() -> str:
    """Return the versioned address of the style sheet."""
    return f"/static/bundle/headland.css?v={_digest(style_sheet())}"


def screen_style_url(name: str) -> str:
    """Return the versioned address of one of ``SCREEN_STYLES``."""
    return f"/static/bundle/{name}.css?v={_digest(screen_style(name))}"


def case_links() -> str:
    """Return the elements that fetch ``CASE_STYLES``, for the page's ``<head>``."""
    links = ((screen_style_url(name), query) for name, query in CASE_STYLES.items())
    return "".join(f'<link rel="stylesheet" href="{url}" media="{query}">' for url, query in links)


def script_url(name: str = "headland") -> str:
    """Return the versioned address of one of ``SCRIPTS``."""
    return f"/static/bundle/{name}.js?v={_digest(script(name))}"


def routes() -> list[Route]:
    """Return the routes that serve the files; they come before the mount of ``/static``."""
    scripts = [Route(f"/static/bundle/{name}.js", partial(_script, name)) for name in SCRIPTS]
    styles = [Route(f"/static/bundle/{name}.css", partial(_screen_style, name)) for name in SCREEN_STYLES]
    return [Route("/static/bundle/headland.css", _style), *styles, *scripts]


def _style(_request: Request) -> Response:
    return Response(style_sheet(), media_type="text/css")


def _screen_style(name: str, _request: Request) -> Response:
    return Response(screen_style(name), media_type="text/css")


def _script(name: str, _request: Request) -> Response:
    return Response(script(name), media_type="application/javascript")


def _lean(text: str) -> str:
    """Drop indents, empty lines and comments; no string of ours spans lines, so what a quote follows may be in one."""
    lines = (_COMMENT.sub("", line).strip() for line in text.splitlines())
    return "\n".join(line for line in lines if line and not line.startswith("//"))


def _digest(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()[:12]
