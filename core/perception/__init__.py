"""From readings to things: landmarks, people, directions of sounds, and how good pictures are."""
