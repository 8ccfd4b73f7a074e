"""Calibration of the camera and of the laser against it (section 3).

Reading order: board, chessboard, homography, projection, bundle, intrinsics, uncertainty, correction;
then planes, range_lines, pairs, extrinsics, board_line, laser_solve; then session and laser_session, the wizards
without a screen; then offline, the same from files.
"""
