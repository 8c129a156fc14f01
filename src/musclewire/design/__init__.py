"""Sizing what a wire pulls: pretensioner and finger, by closed forms and finite elements."""
