"""Actors in the simulated room: people, speakers, board holders."""
