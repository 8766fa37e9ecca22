"""Small HTTP services with open formats: one way to speak to them, used by the clients of planner and forecast."""
