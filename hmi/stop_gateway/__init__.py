"""The STOP gateway: its own process, which does nothing but STOP.

It starts fast, imports no screen, and needs neither console nor database: robot list, revoked tablets and
the presses that are not confirmed yet are files under ``HEADLAND_DATA/stop/``.
The protocol is written down in ``docs/protocols/stop.md``.
"""
