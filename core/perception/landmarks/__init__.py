"""Landmarks: corners of the laser scan confirmed by vertical edges of the picture."""
