"""Learning: from observations to an estimate of the body with honest uncertainty."""
