"""HTTP to services outside without what it is about: one exchange, when to ask again, what a failure means."""
