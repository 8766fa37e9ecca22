"""Tests of hmi.demo."""
