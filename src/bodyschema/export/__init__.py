"""Writing what was learned where other programs read it: the URDF and its companions."""
