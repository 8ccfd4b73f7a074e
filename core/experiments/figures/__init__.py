"""The figures of the paper, drawn by matplotlib."""
