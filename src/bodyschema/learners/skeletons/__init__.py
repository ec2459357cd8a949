"""Joint axes and links of a whole tree, from nothing but what is seen of it."""
