"""From the farm's weather stations to the board the queue reads."""

from __future__ import annotations

from datetime import timedelta

from hmi.clock import Clock
from hmi.commands.weather import WeatherBoard
from hmi.domain.queue.facts import Weather
from hmi.domain.sensors.quantity import Channel
from hmi.store.sensor_board import SensorBoard, ValueNow, usable

RAIN, WIND = Channel("rain_rate"), Channel("wind_speed")


def feed_weather(board: SensorBoard, weather: WeatherBoard, clock: Clock) -> None:
    """Put the worst of what fresh stations measure on the board, as old as the oldest of it.

    Where all there is has no age that is known, what stations told before is taken back.
    """
    now_s = clock.mono_s()
    found: dict[Channel, list[ValueNow]] = {RAIN: [], WIND: []}
    names, is_doubtful = set[str](), False
    for known in board.accepted():
        for channel, values in found.items():
            value = known.values.get(channel)
            if value is None or not value.is_plausible:
                continue
            is_doubtful |= not value.is_dated
            if usable(known, value, now_s):
                values.append(value)
                names.add(known.station.name)
    every = [value for values in found.values() for value in values]
    if not every:
        if is_doubtful:
            weather.take_back()
        return
    oldest_s = min(value.measured_s for value in every)
    rain, wind = (max((value.value for value in values), default=None) for values in found.values())
    at = clock.utc() - timedelta(seconds=max(0.0, now_s - oldest_s))
    weather.take(Weather(at, rain, wind, ", ".join(sorted(names))[:80]))
