"""Recognition: endpointing, engines behind one protocol, the decision."""
