"""Simulated robots and clouds, spoken to over the same wire as real ones."""
