"""Robots with known faults, and whether what is said of them is honest; see `honesty.py`."""
