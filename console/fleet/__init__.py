"""Many robots: the bus between their consoles and the fleet, its certificates, and what of it is known."""
