"""Speech: the room and the browser's microphone to words, words to commands, and the robot's voice."""
