"""The robot's driver and gate as processes, and the pilot's thread."""
