"""Calibration of the camera and of the laser against it (section 3).

Reading order: `board`, `homography`, `projection`, then `camera` (intrinsics, bundle_adjustment, uncertainty,
undistortion), then `laser` (planes, range_lines, plane_pairs, extrinsics, board_line, solve); each has a `session`:
the wizard without a screen. `core.pipelines` does the same from files.
"""
