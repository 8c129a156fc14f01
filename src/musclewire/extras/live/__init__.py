"""A rig operated live from a page in a browser or from a program."""
