"""The pilot: take commands, perceive, estimate, decide, publish."""

from core.pilot.pilot import Pilot

__all__ = ["Pilot"]
