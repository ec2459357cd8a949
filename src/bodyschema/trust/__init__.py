"""Whether an answer may be believed: what disagrees with it, and what would explain the data."""
