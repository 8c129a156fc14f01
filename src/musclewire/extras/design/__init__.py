"""Sizing the parts that a wire pulls: pretensioner and finger, by closed forms and finite elements."""
