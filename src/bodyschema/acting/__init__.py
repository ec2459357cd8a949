"""Acting: where to go next, so that the body becomes better known."""
