"""Objective speech quality evaluation (OSQE, eq. 41-42)."""
