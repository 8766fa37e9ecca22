"""The queue of missions per robot: entries, when they may start, what they wait for, and who armed it. Pure."""
