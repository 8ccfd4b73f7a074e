"""The camera's parameters from pictures of a board (section 3.1)."""
