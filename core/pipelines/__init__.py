"""Pipelines of the command line on files: slam, hear, correct, calibrate."""
