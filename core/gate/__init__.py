"""The gate: the one way to the wheels. Standard library only."""

from core.gate.twist import ZERO, Twist

__all__ = ["ZERO", "Twist"]
