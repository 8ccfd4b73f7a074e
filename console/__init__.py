"""The web console around `core`: command line, server, 3-D scene."""
