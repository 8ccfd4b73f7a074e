"""Sound → direction (eq. 35-40).

`locate` finds one talker, `talkers` several, `locate_as_printed` is the paper's way; `DoaStream` does it while
the sound comes in, and `VoiceTracker` follows voices over time.
"""
