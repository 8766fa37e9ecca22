"""Headland: operator HMI and fleet console for field robots."""

__version__ = "0.1.0"
