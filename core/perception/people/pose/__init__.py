"""People in photographs by landmarks of their bodies: the networks, what they answer, where they look."""
