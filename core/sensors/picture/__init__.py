"""How the simulated camera draws a world."""
