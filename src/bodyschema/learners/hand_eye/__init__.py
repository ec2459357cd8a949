"""Where cameras and targets are, from poses or from one tracked point."""
