"""The nouns everyone shares: a raw sample, a recording, and how recordings are read and written."""
