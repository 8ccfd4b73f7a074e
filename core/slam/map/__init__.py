"""The map: submaps, keyframes, constraints, pose graph, occupancy grid."""
