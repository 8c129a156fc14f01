"""Protection of a heated wire: one table of states, signals and events, and the functions that follow it."""
