"""Scan matching: likelihood field, point-to-line ICP, scan odometry."""
