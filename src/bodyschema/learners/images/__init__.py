"""Joint offsets and poses from what a camera sees of the body."""
