"""Picture quality, and what improves it."""
