"""Recipes on a rig, what they measure, and the one loop that runs them all."""
