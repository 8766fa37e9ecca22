"""The field sensors of the demo farm, and what they measured before it began."""

from __future__ import annotations

from datetime import datetime

from backend_clients.simulator.field.season import Season, season_of
from backend_clients.simulator.field.station import StationConfig

SEED = 1
STATIONS = (
    StationConfig("weather-01", "Weather station", "weather", 51.785767, 4.260901, "polder-17"),
    StationConfig("soil-01", "Soil 1", "soil", 51.788300, 4.259900, "polder-17", 1),
    StationConfig("soil-02", "Soil 2", "soil", 51.785400, 4.258700, "zuidkamp", 2),
    StationConfig("soil-03", "Soil 3", "soil", 51.786500, 4.264700, "oostveld", 3),
    StationConfig("respiration-01", "Respiration 1", "respiration", 51.788250, 4.260050, "polder-17", 1),
    StationConfig("respiration-02", "Respiration 2", "respiration", 51.785350, 4.258850, "zuidkamp", 2),
    StationConfig("respiration-03", "Respiration 3", "respiration", 51.786450, 4.264850, "oostveld", 3),
    StationConfig(
        "multispec-01", "Multispectral 1", "camera", 51.787000, 4.262330, "polder-17", 1, bearing_deg=285.0
    ),
    StationConfig(
        "multispec-02", "Multispectral 2", "camera", 51.787900, 4.263600, "molenhoek", 2, bearing_deg=60.0
    ),
)  # fmt: skip


def season(seed: int, now: datetime, days: int) -> Season:
    """Return what the demo's stations measured until ``now``; the simulator of the same seed goes on from there.

    Pure, and takes about half a second for 120 days: call it on a thread.
    """
    return season_of(STATIONS, seed, now, days)
