"""The whole system in a real browser, over real wire."""
