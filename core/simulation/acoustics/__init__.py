"""Sound on its way through a simulated room: talkers, walls that send it back, noises."""
