"""Speed limits said beforehand: where a reference is faster than its wire, and what would help."""
