"""The REST interface on a real database, against robots that keep the rules."""
