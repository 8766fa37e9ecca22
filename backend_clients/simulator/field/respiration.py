"""Respiration of the soil, as a chamber with an air sampler shows it."""

from __future__ import annotations

from backend_clients.simulator.field.soil import Texture
from backend_clients.simulator.field.weather import vapour_kpa

AIR_CO2 = 415.0  # umol/mol
SOIL_CO2_AT_10_C = 620.0  # what soil of 10 degrees and the best moisture adds to that, umol/mol
Q10 = 2.1  # times as much for each 10 degrees
AIR_KPA = 101.3


def co2_umol_mol(soil_c: float, water: float, texture: Texture) -> float:
    """Return CO2 in the chamber: more in warm soil, most at a little over half of its pores filled."""
    filled = water / texture.full
    wet = max(1 - ((filled - 0.6) / 0.55) ** 2, 0.08)
    return AIR_CO2 + SOIL_CO2_AT_10_C * Q10 ** ((soil_c - 10) / 10) * wet


def h2o_mmol_mol(soil_c: float, water: float, texture: Texture) -> float:
    """Return water vapour in the chamber: nearly saturated over wet soil."""
    damp = 0.72 + 0.27 * min(max(water / texture.capacity, 0.0), 1.0)
    return vapour_kpa(soil_c) * damp / AIR_KPA * 1000
