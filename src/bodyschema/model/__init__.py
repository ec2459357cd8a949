"""The body: an immutable kinematic tree, its kinematics, and what may be wrong with it."""
