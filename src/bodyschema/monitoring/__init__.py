"""Monitoring: is the body still as learned, and if not, which part has changed."""
