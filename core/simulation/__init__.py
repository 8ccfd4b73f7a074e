"""The simulator: world, acoustics, rendering, actors and the simulated robot."""
