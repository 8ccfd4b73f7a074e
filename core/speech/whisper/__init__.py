"""Whisper in plain numpy: a model file is read, and its decoder searches the grammar beside free text."""
