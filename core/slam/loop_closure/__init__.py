"""Loop closure: places that are recognized become constraints of the pose graph."""
