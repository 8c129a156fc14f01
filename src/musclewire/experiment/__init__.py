"""Recipes on a rig, their measures, and the one loop that runs them all."""
