"""Control: commands, stop, the lease, pending commands, history, playback."""
