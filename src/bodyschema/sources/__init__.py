"""Recordings: tables of joint positions and observations, read with units and validated by row."""
