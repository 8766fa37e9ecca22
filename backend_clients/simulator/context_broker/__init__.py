"""A context broker that behaves like Orion 4.3 on the wire, with its entities in memory.

``docs/protocols/ngsi.md`` lists what it leaves out.
"""
