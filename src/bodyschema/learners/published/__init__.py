"""Published learners, as printed."""
