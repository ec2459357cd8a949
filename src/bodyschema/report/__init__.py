"""What a calibration found, as one self-contained page for people."""
