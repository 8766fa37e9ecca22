"""Simulated robots: their own process, the same wire and the same rules as a real machine.

Nothing in the console may import this package but the command line; the console meets it over
MQTT and HTTP only.
"""
