"""The program `beckon fleet`: the router of the fleet, its page, and every robot's console through it."""
