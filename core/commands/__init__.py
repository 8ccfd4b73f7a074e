"""Table 2: what the robot can be told. One file per command, listed in VOCABULARY."""

from __future__ import annotations
