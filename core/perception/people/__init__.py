"""People: where in the picture, where by the laser, and both followed over time (section 4.2, eq. 34, Fig. 7)."""
