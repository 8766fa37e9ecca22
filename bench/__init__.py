"""Every published number has its script here; each prints JSON lines with the naive way beside it."""
