"""What a run file is made of, and how it is read: senses, parts of the model, and moments."""
