"""Transcription: a stream of sound to words."""
