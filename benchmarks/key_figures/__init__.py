"""The key figures of every part of the product; `benchmarks/figures.py` prints them."""
