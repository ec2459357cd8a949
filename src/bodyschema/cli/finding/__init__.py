"""`bodyschema find-body`: the search over a clip, and what it answers."""
