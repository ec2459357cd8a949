"""What was learned of a body without markers, as one self-contained page for people."""
