"""Frozen types and pure rules of the console. Imports nothing of ours but itself."""
