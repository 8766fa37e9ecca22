"""Tests of missions: their life, storage, tracking, book and routes."""
