"""A gate on simulated time with everything around it well: what a test needs to break one thing at a time."""

from collections.abc import Sequence

from core.gate import TICK_S, Gate, Limits, Setpoint, TraceRow, TraceWriter, check
from core.gate.setpoint import Source


class Bench:
    """Runs ticks; the console beats, scans come at 10 Hz and are empty, until told otherwise."""

    def __init__(self, limits: Limits | None = None, *, halted: bool = False, armed: bool = True) -> None:
        self.limits = limits or Limits()
        self.trace = TraceWriter()
        self.gate = Gate(self.limits, halted=halted, trace=self.trace)
        self.now = 100.0
        self.beats = self.scans = True
        self.points: list[tuple[float, float]] = []
        self._ticks = 0
        self._seq = 0
        self.run(0.1)
        if armed:
            assert self.gate.arm(1, "ann", self.now) == ""
            self.let_go()

    def run(self, seconds: float) -> None:
        for _ in range(round(seconds / TICK_S)):
            self.tick()

    def tick(self) -> None:
        self.now += TICK_S
        if self.beats:
            self.gate.heartbeat(self.now)
        if self.scans and self._ticks % 5 == 0:
            self.gate.see(self.points, self.now)
        self._ticks += 1
        self.gate.tick(self.now)

    def order(
        self, source: Source, v: float, w: float, press: int, *, epoch: int = 1, nonce: int | None = None
    ) -> Setpoint:
        self._seq += 1
        nonce = self.gate.status().nonce if nonce is None else nonce
        return Setpoint(epoch=epoch, seq=self._seq, source=source, press=press, v=v, w=w, nonce=nonce)

    def jog(self, v: float, w: float = 0.0, press: int = 1, *, epoch: int = 1) -> str:
        return self.gate.accept(self.order("jog", v, w, press, epoch=epoch), self.now)

    def goal(self, v: float, w: float = 0.0, press: int = 1, *, epoch: int = 1) -> str:
        return self.gate.accept(self.order("goal", v, w, press, epoch=epoch), self.now)

    def let_go(self) -> None:
        self.jog(0.0)
        self.tick()

    def hold(
        self, source: Source, v: float, w: float = 0.0, press: int = 1, *, seconds: float, epoch: int = 1
    ) -> None:
        """Orders at 50 Hz for so long."""
        for _ in range(round(seconds / TICK_S)):
            self.gate.accept(self.order(source, v, w, press, epoch=epoch), self.now)
            self.tick()

    @property
    def speed(self) -> float:
        return self.gate.twist.v

    @property
    def rows(self) -> list[TraceRow]:
        return self.trace.rows

    def complaints(self) -> list[str]:
        return check(self.rows, self.limits)


def motion_after(rows: Sequence[TraceRow], t: float) -> list[TraceRow]:
    """The rows later than `t` [s] in which something moves."""
    return [row for row in rows if row.t_mono_ns > round(t * 1e9) and (row.v != 0.0 or row.w != 0.0)]
