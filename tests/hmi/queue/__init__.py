"""The queue of missions per robot."""
