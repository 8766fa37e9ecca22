"""Field sensors on stage: stations whose values move, their history, and what a test lets go wrong.

``wish``: ``none``, ``status``, ``hang``, ``stations`` (changes by id), ``drop`` (ids), ``gate``, ``forecast``,
``hole_h`` (gap in the history), ``refuse`` (part of a path to an answer), ``outcome`` (of a trigger).
Times are the console's own.
"""

from __future__ import annotations

import asyncio
import math
from collections.abc import Callable
from datetime import UTC, datetime, timedelta
from typing import Any

from fastapi import APIRouter, Request
from fastapi.responses import JSONResponse

from hmi.domain.role import Role

PLANS, TRIGGERS = {Role.PLANNER, Role.ADMIN}, {Role.OPERATOR, Role.PLANNER, Role.SUPERVISOR, Role.ADMIN}
HOLE_FROM_H = 9.0
SPANS = {"24h": (86_400, 600), "7d": (7 * 86_400, 3600), "season": (120 * 86_400, 86_400)}
WAITS = {
    "state": "waits",
    "sentence": "Wind 6.1 m/s, limit 5.0: waits",
    "facts": [
        {"label": "Wind", "text": "6.1 m/s, limit 5.0", "ok": False},
        {"label": "Rain", "text": "0.0 mm/h, limit 0.2", "ok": True},
    ],
}
OPEN = {
    "state": "open",
    "sentence": "Weather is within the treatment limits.",
    "facts": [
        {"label": "Wind", "text": "3.4 m/s, limit 5.0", "ok": True},
        {"label": "Rain", "text": "0.0 mm/h, limit 0.2", "ok": True},
    ],
}
LIMITS = [
    {"quantity": "wind_speed", "depth_m": None, "label": "Wind", "unit": "m/s", "low": None, "high": 5.0},
    {"quantity": "rain_rate", "depth_m": None, "label": "Rain", "unit": "mm/h", "low": None, "high": 0.2},
    {"quantity": "soil_moisture", "depth_m": 0.1, "label": "Soil 10 cm", "unit": "%", "low": 14.0, "high": 38.0},
]
# middle, swing over a day, label, unit, limit
CHANNELS: dict[str, tuple[float, float, str, str]] = {
    "air_temperature": (16.0, 6.0, "Air", "°C"),
    "wind_speed": (3.4, 1.2, "Wind", "m/s"),
    "wind_gust": (5.1, 1.8, "Gusts", "m/s"),
    "wind_bearing": (235.0, 8.0, "Wind from", "°"),
    "rain_rate": (0.0, 0.0, "Rain", "mm/h"),
    "air_humidity": (64.0, 18.0, "Humidity", "%"),
    "radiation": (420.0, 380.0, "Radiation", "W/m²"),
    "soil_moisture@0.10": (21.0, 1.2, "Soil 10 cm", "%"),
    "soil_moisture@0.30": (24.0, 0.6, "Soil 30 cm", "%"),
    "soil_moisture@0.60": (27.0, 0.2, "Soil 60 cm", "%"),
    "soil_temperature@0.10": (14.0, 3.0, "Soil temperature 10 cm", "°C"),
    "soil_temperature@0.30": (12.5, 1.0, "Soil temperature 30 cm", "°C"),
    "soil_temperature@0.60": (11.0, 0.3, "Soil temperature 60 cm", "°C"),
    "co2": (620.0, 140.0, "CO2", "ppm"),
    "h2o": (14.0, 3.0, "Water vapour", "mmol/mol"),
}
SKY = ("air_temperature", "wind_speed", "wind_gust", "wind_bearing", "rain_rate", "air_humidity", "radiation")
GROUND = tuple(key for key in CHANNELS if key.startswith("soil"))
AIR = ("co2", "h2o", "soil_temperature@0.10")


def station(name: str, kind: str, keys: tuple[str, ...], lat: float, lon: float, **more: Any) -> dict[str, Any]:
    """Return a station that reports every minute and was heard some seconds ago."""
    usual = {"parcel": "polder-17", "parcel_name": "Polder 17", "is_accepted": True, "period_s": 60.0, "battery": 0.81}
    return {
        **usual,
        "name": name,
        "kind": kind,
        "keys": keys,
        "lat_deg": lat,
        "lon_deg": lon,
        "heard_s_ago": 8.0,
        "revision": f"first of {name}",
        **more,
    }


STATIONS = {
    "weather-01": station("Weather station", "weather", SKY, 51.7512, 5.7488, model="WS-500", battery=None),
    "soil-01": station("Soil 1", "soil", GROUND, 51.7505, 5.7505),
    "soil-02": station("Soil 2", "soil", GROUND, 51.7498, 5.7520, parcel="nordfeld-12", parcel_name="Nordfeld 12"),
    "soil-03": station("Soil 3", "soil", GROUND, 51.7490, 5.7492, battery=0.09, heard_s_ago=6 * 3600.0),
    "respiration-01": station("Respiration 1", "respiration", AIR, 51.7508, 5.7530),
    "multispec-01": station("Multispectral 1", "camera", (), 51.7516, 5.7515, period_s=3600.0, heard_s_ago=1300.0),
    "soil-09": station("soil-09", "soil", GROUND, 51.7487, 5.7533, is_accepted=False, parcel=None, parcel_name=None),
}


class SensorStage:
    """The stations, and what was asked of them."""

    def __init__(self, now_s: Callable[[], float]) -> None:
        self._now_s = now_s
        self.reset()

    def reset(self) -> None:
        """Begin anew."""
        self.begun_s = self._now_s()
        self.wish: dict[str, Any] = {}
        self.asked: list[dict[str, Any]] = []
        self.polls = 0
        self.changes: dict[str, dict[str, Any]] = {}
        self.gone: set[str] = set()
        self.limits = [
            {**one, "is_treatment": True, "note": "", "by": "Anna Ostermeier", "at": "2026-05-18T07:12:00Z"}
            for one in LIMITS
        ]
        self.calibrations: dict[str, list[dict[str, Any]]] = {}

    def stations(self) -> list[dict[str, Any]]:
        """Return what ``GET /sensors`` lists."""
        found = []
        for key, own in STATIONS.items():
            if key in self.gone or key in self.wish.get("drop", ()) or self.wish.get("none"):
                continue
            change = {**self.changes.get(key, {}), **self.wish.get("stations", {}).get(key, {})}
            found.append(self._told(key, {**own, **change}))
        return found

    def _told(self, key: str, own: dict[str, Any]) -> dict[str, Any]:
        own = dict(own)
        keys, heard = own.pop("keys"), own.pop("heard_s_ago")
        period = own["period_s"]
        is_never = heard is None
        # a station goes on reporting: its age runs up to its period and begins anew
        is_quiet = not is_never and heard > 3 * period
        age = None if is_never else heard + (self._now_s() - self.begun_s if is_quiet else 0.0)
        state = "never" if is_never else "silent" if age > 3 * period else "late" if age > 1.5 * period else "fresh"
        heard_utc = None if age is None else (datetime.now(UTC) - timedelta(seconds=age)).isoformat()
        low = own["battery"] is not None and own["battery"] < 0.15
        silence = f"{own['name']} silent for {round((age or 0) / 3600)} h." if state == "silent" else ""
        sentence = " ".join(
            part for part in (silence, f"Battery {own['battery'] * 100:.0f} % when last heard." if low else "") if part
        )
        usual = {"id": key, "model": None, "state": state, "age_s": age, "heard_utc": heard_utc, "battery_low": low}
        usual |= {"sentence": sentence, "notice": None, "camera": None, "pictures_today": 0, "pictures_limit": None}
        if own["kind"] == "camera":
            usual |= {"camera": f"field/{key}", "pictures_today": 7, "pictures_limit": 100}
        values = [] if is_never else [self._value(one, key, age, state) for one in keys]
        return {**usual, "values": values, **own, **{k: own[k] for k in ("values",) if k in own}}

    def _value(self, key: str, name: str, age: float | None, state: str) -> dict[str, Any]:
        quantity, _, depth = key.partition("@")
        depth_m = float(depth) if depth else None
        _, _, label, unit = CHANNELS[key]
        limit = next((o for o in self.limits if o["quantity"] == quantity and o["depth_m"] in (None, depth_m)), None)
        value = round(self._at(key, name, datetime.now(UTC)) + (2.7 if self._is_windy(key) else 0), 1)
        bounds = limit and {key: limit[key] for key in ("low", "high", "is_treatment")}
        is_over = bool(bounds and bounds["high"] is not None and value > bounds["high"])
        head = {"key": key, "quantity": quantity, "label": label, "unit": unit, "depth_m": depth_m, "value": value}
        return {**head, "age_s": age, "state": state, "limit": bounds, "is_over": is_over, "trend": "up"}

    def _is_windy(self, key: str) -> bool:
        return key == "wind_speed" and self.gate()["state"] == "waits"

    @staticmethod
    def _at(key: str, name: str, when: datetime) -> float:
        middle, swing, *_ = CHANNELS[key]
        day = (when.timestamp() % 86_400) / 86_400
        own = (sum(map(ord, name)) % 7) / 7 * swing
        return max(
            0.0,
            middle + swing * math.sin(2 * math.pi * (day - 0.3)) + own + 0.1 * swing * math.sin(when.timestamp() / 900),
        )

    def gate(self) -> dict[str, Any]:
        """Return whether treatment may go on."""
        found: dict[str, Any] = self.wish.get("gate") or OPEN
        return WAITS if found == "waits" else found

    def series(self, name: str, quantity: str, depth_m: float | None, span: str) -> dict[str, Any]:
        """Return the course of one value, with the hole a test asked for."""
        key = quantity if depth_m is None else f"{quantity}@{depth_m:.2f}"
        length_s, step_s = SPANS[span]
        now = datetime.now(UTC)
        hole = timedelta(hours=self.wish.get("hole_h", 0))
        hole_from = now - timedelta(hours=HOLE_FROM_H)
        points: list[list[Any]] = []
        for i in range(length_s // step_s, -1, -1):
            when = now - timedelta(seconds=i * step_s)
            if hole and hole_from <= when <= hole_from + hole:
                points.append([when.isoformat(), None, None, None])
                continue
            mean = self._at(key, name, when)
            swing = CHANNELS[key][1] * (0.25 if span != "season" else 0.8)
            points.append([when.isoformat(), round(mean, 2), round(max(0, mean - swing), 2), round(mean + swing, 2)])
        limit = next((o for o in self.limits if o["quantity"] == quantity and o["depth_m"] in (None, depth_m)), None)
        ended = (now - timedelta(hours=14)).isoformat()
        treatments = [
            {"from_utc": (now - timedelta(hours=17)).isoformat(), "to_utc": ended, "text": "Polder 17, weeder-01"},
            {"from_utc": (now - timedelta(minutes=50)).isoformat(), "to_utc": None, "text": "Nordfeld 12, weeder-07"},
        ]
        bounds = {"low": limit["low"], "high": limit["high"]} if limit else {"low": None, "high": None}
        return {
            "unit": CHANNELS[key][3],
            "step_s": step_s,
            "points": points,
            "limits": bounds,
            "treatments": treatments,
        }


def forecast(state: str) -> dict[str, Any]:
    """Return the hours to come."""
    now = datetime.now(UTC).replace(minute=0, second=0, microsecond=0)
    hours = [
        {
            "utc": (now + timedelta(hours=i)).isoformat(),
            "air_temperature": 15 + 5 * math.sin(i / 4),
            "rain_rate": 0.6 if 5 <= i <= 7 else 0.0,
            "wind_speed": 3.0 + i / 6,
        }
        for i in range(24)
    ]
    said = {
        "fresh": "Forecast by Weather service, made 15:20, 40 min ago.",
        "old": "Made 9 h ago. It is not renewed.",
        "failed": "The service does not answer.",
    }
    return {"state": state, "sentence": said[state], "made_utc": now.isoformat(), "hours": hours}


def router(stage: SensorStage, sessions: Any) -> APIRouter:
    """Return the routes of sensors and those that tests set them by."""
    api = APIRouter()

    def rights(request: Request) -> dict[str, bool]:
        session = sessions.of_headers(request.scope["headers"])
        role = session.role if session else Role.VIEWER
        plans = role in PLANS
        return {"accept": plans, "limits": plans, "calibrate": plans, "trigger": role in TRIGGERS}

    @api.post("/stage-sensors")
    async def adjust(request: Request) -> dict[str, Any]:
        wish = await request.json()
        if wish.pop("anew", False):
            stage.reset()
        stage.wish.update(wish)
        return {}

    @api.get("/stage-sensors")
    async def heard() -> dict[str, Any]:
        return {"asked": stage.asked, "polls": stage.polls}

    @api.get("/api/v1/fields")
    async def fields() -> dict[str, Any]:
        return {
            "fields": [{"id": "polder-17", "name": "Polder 17"}, {"id": "nordfeld-12", "name": "Nordfeld 12"}],
            "homes": [],
            "areas": [],
        }

    @api.get("/api/v1/sensors")
    async def sensors(request: Request) -> Any:
        stage.polls += 1
        if stage.wish.get("hang"):
            await asyncio.sleep(stage.wish["hang"])
        if stage.wish.get("status"):
            return JSONResponse({"code": "down", "text": "The server is being started."}, stage.wish["status"])
        told = stage.wish.get("forecast")
        return {
            "stations": stage.stations(),
            "gate": stage.gate(),
            "forecast": forecast(told) if told else None,
            "now_utc": datetime.now(UTC).isoformat(),
            "can": rights(request),
        }

    @api.get("/api/v1/sensors/{name}/series")
    async def series(name: str, quantity: str, span: str, depth_m: float | None = None) -> Any:
        return _refusal(stage, "series") or stage.series(name, quantity, depth_m, span)

    @api.get("/api/v1/sensors/{name}/calibration")
    async def calibrations(name: str) -> Any:
        return stage.calibrations.get(name, [])

    _changes(api, stage)
    return api


def _refusal(stage: SensorStage, path: str) -> JSONResponse | None:
    for part, (status, body) in stage.wish.get("refuse", {}).items():
        if part in path:
            return JSONResponse(body, status)
    return None


def _changes(api: APIRouter, stage: SensorStage) -> None:
    """Add the routes by which people change limits and stations."""

    @api.get("/api/v1/sensor-limits")
    async def limits() -> Any:
        return stage.limits

    @api.put("/api/v1/sensor-limits")
    async def set_limits(request: Request) -> Any:
        body = await request.json()
        stage.asked.append({"path": "sensor-limits", **body})
        refused = _refusal(stage, "sensor-limits")
        if refused is None:
            known = {(one["quantity"], one["depth_m"]): one for one in stage.limits}
            fresh = {"by": "Pieter Bos", "at": datetime.now(UTC).isoformat()}
            stage.limits = [
                {**known.get((one["quantity"], one["depth_m"]), {}), **one, **fresh} for one in body["limits"]
            ]
        return refused or stage.limits

    @api.api_route("/api/v1/sensors/{name}{rest:path}", methods=["POST", "PUT", "DELETE"])
    async def change(name: str, rest: str, request: Request) -> Any:
        body = await request.json() if await request.body() else {}
        stage.asked.append({"method": request.method, "path": f"{name}{rest}", **(body or {})})
        refused = _refusal(stage, f"{name}{rest}")
        if refused:
            return refused
        if rest == "/trigger":
            return stage.wish.get("outcome") or {"outcome": "accepted", "text": "The picture was taken."}
        if rest == "/calibration":
            entry = {**body, "by": "Pieter Bos", "at": datetime.now(UTC).isoformat()}
            stage.calibrations.setdefault(name, []).insert(0, entry)
        elif request.method == "DELETE":
            stage.gone.add(name)
        else:
            body["parcel_name"] = {"polder-17": "Polder 17", "nordfeld-12": "Nordfeld 12"}.get(body.get("parcel") or "")
            stage.changes.setdefault(name, {}).update(body, is_accepted=True)
        return {}
