"""Simulated field sensors: weather, soil, respiration of the soil, field cameras, over the wire of real ones.

Weather is a function of seed and time alone, so history, live values and a second simulator agree.
"""
