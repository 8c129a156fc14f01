"""Emulated hardware that drives the simulated wire, for tests and for trials without a bench."""
