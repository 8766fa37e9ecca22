"""``python -m bench [NAME]``: print all figures, or the one called NAME, as JSON lines."""

from __future__ import annotations

import importlib
import json
import sys

MODULES: dict[str, tuple[str, ...]] = {
    "bench.stop": ("stop_idle_p99_ms", "stop_loaded_p99_ms", "stop_burst_p99_ms", "stop_storm_p99_ms"),
    "bench.fanout": ("fanout_cpu_pct", "fanout_naive_ratio"),
    "bench.ingest": ("ingest_4k_cpu_pct", "ingest_4k_lost"),
    "bench.alarm_watch": ("alarm_watch_cpu_pct", "alarm_burst_ms"),
    "bench.history": ("history_rows_per_s",),
    "bench.planning": (
        "plan_square_3m_s",
        "plan_square_05m_s",
        "plan_lshape_3m_s",
        "plan_lshape_05m_s",
        "plan_nc12_3m_s",
        "plan_nc12_05m_s",
        "plan_nl_parcel_3m_s",
        "plan_nl_parcel_05m_s",
        "plan_field100_3m_s",
        "plan_field100_05m_s",
    ),
    "bench.fleet": ("fleet_viewer_cpu_points",),
    "bench.map": ("map_update_ms_1000", "map_update_ms_5000"),
    "bench.import_large": ("import_20mb_s", "import_20mb_mb", "import_20mb_stall_ms"),
    "bench.editor": ("editor_drag_ms_10000",),
    "bench.planter_times": ("planter_total_s",),
    "bench.twin": ("twin_50x10_cpu_pct", "twin_naive_ratio"),
    "bench.twin_browser": ("twin_reconnect_ms",),
    "bench.video": (
        "video_32_viewers_cpu_pct",
        "video_viewer_naive_ratio",
        "video_delay_p50_ms",
        "video_first_frame_ms",
        "video_large_cpu_pct",
    ),
    "bench.notification_storm": ("notify_storm_cpu_points", "notify_storm_rest_p99_ms", "notify_storm_newest_s"),
    "bench.video_browser": (
        "video_seen_cold_ms",
        "video_seen_ms",
        "video_true_delay_ms",
        "video_stall_ms",
        "video_fallback_ms",
        "video_freed_ms",
    ),
    "bench.simulator": ("simulator_fleet_cpu_pct", "simulator_lean_cpu_pct"),
    "bench.camera_pictures": ("camera_picture_640_ms", "camera_picture_2048_ms"),
    "bench.demo": (
        "demo_ready_s",
        "screen_delay_p50_ms",
        "screen_delay_p99_ms",
        "console_idle_cpu_pct",
        "console_idle_cloud_cpu_pct",
        "console_page_cpu_points",
        "page_cold_kb",
        "page_warm_kb",
    ),
}


def main(arguments: list[str]) -> int:
    """Run the modules that are asked for; exit code 1 for an unknown name."""
    wanted = arguments[0] if arguments else None
    chosen = [m for m, names in MODULES.items() if wanted is None or wanted in names]
    if not chosen:
        names = ", ".join(sorted(name for names in MODULES.values() for name in names))
        print(f"Unknown figure {wanted!r}. Known: {names}", file=sys.stderr)
        return 1
    for module in chosen:
        for figure in importlib.import_module(module).run():
            if wanted is None or figure["name"] == wanted:
                print(json.dumps(figure), flush=True)
            if figure["name"] == wanted:
                return 0
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
