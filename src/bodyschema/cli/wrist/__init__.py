"""Recordings of a wrist sensor: their files, columns and units, and what is answered."""
