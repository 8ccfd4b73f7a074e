"""Lines, solids and colours of the 3-D scene."""
