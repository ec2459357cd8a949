"""What hangs on a wrist, from its force/torque sensor."""
