"""Relocalization: noticing that the robot is lost or was kidnapped, and finding its pose again."""
