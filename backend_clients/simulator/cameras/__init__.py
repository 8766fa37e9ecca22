"""The cameras of the simulated robots: pictures of the simulated world, drawn in a process of their own.

The simulator's loop takes a ``Look`` (where everything is now) and a ``Scene`` (the ground around a robot), and the
process beside it draws and encodes them. A picture nobody asks for costs nothing.
"""
