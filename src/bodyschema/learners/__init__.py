"""Learners that go on: recursive, in windows, by several hypotheses."""
