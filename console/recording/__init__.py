"""Recordings of what the robot senses and does."""
