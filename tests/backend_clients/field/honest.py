"""One honest message of each kind, with everything in it."""

from __future__ import annotations

from datetime import UTC, datetime, timedelta

from backend_clients.field import messages as m
from backend_clients.field.codec import Message
from backend_clients.field.topics import Down, Up

STATION = "soil-01"
NOON = datetime(2026, 5, 14, 12, 0, tzinfo=UTC)


def honest() -> dict[Up | Down, Message]:
    """Return the messages by kind."""
    return {
        Up.ABOUT: m.About(
            station=STATION,
            name="Soil 1",
            kind="soil",
            lat_deg=50.1,
            lon_deg=4.2,
            period_s=600.0,
            quantities=[m.Quantity(quantity="soil_moisture", unit="m3/m3", depth_m=0.1)],
            model="Probe 3",
            parcel="field-1",
        ),
        Up.DATA: m.Data(
            station=STATION,
            boot="boot-0001",
            seq=7,
            utc=NOON,
            values=[
                m.Reading(quantity="soil_moisture", value=0.21, depth_m=0.1),
                m.Reading(quantity="soil_moisture", value=0.24, depth_m=0.3),
            ],
            battery=0.8,
            notice="notice-01",
        ),
        Up.ACK: m.Ack(station=STATION, id="notice-01", outcome="accepted", text="Treatment is under way."),
        Down.NOTICE: m.Notice(
            station=STATION,
            id="notice-01",
            utc=NOON,
            is_treating=True,
            robots=["weeder-01"],
            parcel="field-1",
            until_utc=NOON + timedelta(minutes=5),
        ),
        Down.TRIGGER: m.Trigger(station=STATION, id="trigger-1", utc=NOON, ttl_s=5.0),
    }
