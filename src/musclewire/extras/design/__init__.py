"""Sizing of what a wire pulls: pretensioner and finger."""
