"""Simulated wires: state in, state out."""
