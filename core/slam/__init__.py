"""Simultaneous localization and mapping: the robot's pose and the map of the building (section 4.1).

`mapper` is the way in. One submap is one filter as the paper has it (`ekf_slam`, `ekf`, `association`), which
`bearings` joins by landmarks of which only bearings are measured; `map` holds
the submaps together in a pose graph, `scan_matching` aligns scans, `loop_closure` adds constraints where a place is
recognized again, `relocalization` finds a lost robot. What is heavy is done in small pieces, a few with every frame.
"""
