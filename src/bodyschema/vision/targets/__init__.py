"""Boards and tags: what they look like, and where pictures show their corners."""
