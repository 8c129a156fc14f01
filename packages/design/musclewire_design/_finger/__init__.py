"""A flexible finger that a tendon bends: statics at large deflection, sizing, drawing."""
