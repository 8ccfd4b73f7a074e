"""The generated pages and types of `static`: `python -m tests.reference` writes them, tests keep them equal."""
