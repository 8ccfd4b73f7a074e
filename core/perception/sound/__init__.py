"""Sound → direction (eq. 35-40): `locate` for one talker, `talkers` for several, `locate_as_printed` for the paper's way."""
