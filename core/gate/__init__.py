"""The gate: the one way to the wheels. Standard library only."""

from core.gate.gate import LATE_TICK_S, TICK_S, Gate
from core.gate.limits import Limits
from core.gate.setpoint import Setpoint
from core.gate.status import GateStatus
from core.gate.trace import TraceRow, TraceWriter, check, read_trace
from core.gate.twist import ZERO, Twist

__all__ = [
    "LATE_TICK_S",
    "TICK_S",
    "ZERO",
    "Gate",
    "GateStatus",
    "Limits",
    "Setpoint",
    "TraceRow",
    "TraceWriter",
    "Twist",
    "check",
    "read_trace",
]
