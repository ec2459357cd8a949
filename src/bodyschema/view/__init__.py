"""A result in space: one self-contained page that can be turned, from a file or on loopback."""
