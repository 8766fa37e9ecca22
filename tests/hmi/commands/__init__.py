"""Commands, leases, driving and resets against a robot that keeps the rules."""
