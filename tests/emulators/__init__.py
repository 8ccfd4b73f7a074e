"""Robots on a real wire without hardware: each emulates one kind of link, with the simulated robot behind it."""
