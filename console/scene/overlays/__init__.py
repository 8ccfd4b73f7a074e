"""One file per overlay of the 3-D scene."""
