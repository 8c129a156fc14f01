"""A sensing model from resistance alone: a named wire as prior, marks on a ruler, and how far the model may be off."""
