"""Calibrations, pictures and scans in files."""
