"""What a person gets: a verdict, an estimate, and how far to trust it."""
