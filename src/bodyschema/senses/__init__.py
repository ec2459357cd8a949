"""Senses: what is seen of the body, predicted from the body, with derivatives; one file each."""
