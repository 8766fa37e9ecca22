"""Tests of hmi.planning."""
