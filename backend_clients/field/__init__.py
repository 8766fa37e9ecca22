"""Field sensor contract v1: how a station in a field and the console talk over MQTT.

The contract is written down in ``docs/protocols/field_sensors.md``; the models here are its source.
"""
