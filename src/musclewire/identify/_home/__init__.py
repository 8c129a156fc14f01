"""The home move's evidence: a sweep at a known load against the loop that a model was fitted to. It drives no rig."""
