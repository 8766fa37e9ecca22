"""Services of the demo's cloud beside its context broker, in the same process: none further starts for them."""

from __future__ import annotations

from typing import Any

PLANNER_PATH, FORECAST_PATH = "/planner-service", "/forecast-service"


def beside_the_broker(*, has_planner: bool, has_forecast: bool, seed: int = 1) -> dict[str, Any]:
    """Return what the demo's cloud serves beside its context broker, by path; planning starts with the first wish."""
    found: dict[str, Any] = {}
    if has_forecast:
        from backend_clients.simulator.forecast import ForecastEndpoint

        found[FORECAST_PATH] = ForecastEndpoint(seed).application()
    if has_planner:
        from hmi.planning_service.application import make_application
        from hmi.planning_service.desk import PlanDesk

        found[PLANNER_PATH] = make_application(PlanDesk())
    return found
