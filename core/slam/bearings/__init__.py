"""Landmarks of which only bearings are measured: vertical edges in pictures, and a person who calls."""
