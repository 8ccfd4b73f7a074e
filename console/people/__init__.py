"""Enrollment of people, and the stored people."""
