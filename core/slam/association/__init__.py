"""Data association: sightings to landmarks, and the landmark table."""
