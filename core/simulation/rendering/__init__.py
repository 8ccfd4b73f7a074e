"""Rendering of the simulated camera's pictures."""
