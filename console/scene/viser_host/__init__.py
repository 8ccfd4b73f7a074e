"""viser inside the console's own process, without a socket of its own."""
