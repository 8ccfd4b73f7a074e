"""The camera's mount on the laser (section 3.2)."""
