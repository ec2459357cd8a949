"""Watching hand and eye in the pictures of a stereo pair."""
