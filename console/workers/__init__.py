"""Killable worker processes, for dangerous or slow jobs."""
