"""Where the robot is and what the room looks like (section 4.1)."""
