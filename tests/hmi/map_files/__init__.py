"""Tests of hmi.map_files."""
