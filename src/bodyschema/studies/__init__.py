"""Published experiments, one file each: their protocol, their numbers beside ours, their figure."""
