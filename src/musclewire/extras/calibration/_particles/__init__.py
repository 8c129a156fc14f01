"""The particle filter: strain by the user's own wire file, whatever load and air do."""
