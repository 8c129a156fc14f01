"""The ring: parts that the core does not know. Each folder is found by its ``manifest.py``."""
