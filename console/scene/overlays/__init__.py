"""The overlays of the 3-D scene."""
