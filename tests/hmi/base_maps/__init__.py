"""Tests of base maps."""
