"""The default recognizer: pocketsphinx with a grammar and a garbage model, keyword spotting."""
