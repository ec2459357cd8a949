"""Which part of the view is me: optical flow, motion coincidence, the visual Jacobian."""
