"""From readings to things: corners, edges, landmarks."""
