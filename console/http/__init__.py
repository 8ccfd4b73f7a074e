"""HTTP itself: problems, timeouts, connection limits, downloads."""
