"""Experiments that the console runs: what there is, one at a time in processes of their own, and kept results."""
