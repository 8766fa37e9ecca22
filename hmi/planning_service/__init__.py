"""Planning as a service: our planner behind the open format, and the console's planner that asks such a service.

It is no part of the simulator, which may not know the console's planner: it plans for real, with ``hmi.planning``.
"""
