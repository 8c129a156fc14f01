"""Physical parameters of a wire from recordings: what is unknown, what was observed, search, uncertainty."""
