"""The subcommands of `beckon`, one file each: `add` to the parser, `run` when chosen."""

from __future__ import annotations

from console.cli import calibrate, correct, doctor, experiment, hear, run, settings, slam, speech_quality, understand

SUBCOMMANDS = (run, calibrate, correct, slam, hear, understand, speech_quality, experiment, settings, doctor)
