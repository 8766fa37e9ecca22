"""NGSI-v2 client: entities and subscriptions of a context broker such as Orion.

``docs/protocols/ngsi.md`` says what it does and what it refuses to do.
"""
