"""Edge contract v1: how a robot and the console talk over MQTT and HTTP.

The contract is written down in ``docs/protocols/edge.md``; the models here are its source.
"""
