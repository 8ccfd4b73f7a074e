"""Recognition: endpointing, engines, acceptance."""
