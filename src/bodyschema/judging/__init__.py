"""Which model the data speak for, and how far to trust what it says."""
