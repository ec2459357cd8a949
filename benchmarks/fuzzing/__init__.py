"""Damaged and hostile input: seeds, mutations, readers, and the bench that runs them."""
