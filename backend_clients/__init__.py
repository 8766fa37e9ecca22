"""Clients of everything outside the console: robots at the edge, clouds, simulators.

No module here imports a screen, a store or a web framework; every client is usable from a REPL.
"""
