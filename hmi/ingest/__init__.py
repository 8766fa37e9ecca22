"""From the wire into the store, and orders onto the wire."""
