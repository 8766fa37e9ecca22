"""FIWARE smart data models: our farm, robots and work as entities, and back; pure, one module a model.

Every builder returns key-values, the simplified form of NGSI, valid against the published schema of its model.
``normalized`` turns them into what a context broker keeps, and back.
"""
