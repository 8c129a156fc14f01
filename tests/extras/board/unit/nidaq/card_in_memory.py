"""The output of a card in memory, and the orders for a guardian of it."""

from __future__ import annotations

from dataclasses import dataclass, field

from musclewire.extras.board._nidaq.driver import DaqFaultError, OutputSettings
from musclewire.extras.board._nidaq.guardian import GuardianOrders

__all__ = ["OFF_V", "ORDERS", "CardInMemory"]

# A drive voltage of 2 V is 1.1 V at the terminal; 0 V is 0.1 V.
GAIN, OFFSET_V = 2.0, -0.2
ORDERS = GuardianOrders(
    OutputSettings("Dev1", "127.0.0.1:1", "ao0", 10.0, None), GAIN, OFFSET_V, 0.3, sense_after_s=0.1, trip_after_s=0.25
)
OFF_V = 0.1


@dataclass
class CardInMemory:
    """The output of a card; ``refuses`` are the calls that fail, each as often as it is named."""

    clock: float | None = None
    refuses: list[str] = field(default_factory=list)
    out: list[tuple[str, float]] = field(default_factory=list)
    closed: bool = False
    released: bool = False

    def _put(self, how: str, voltage_v: float) -> None:
        if how in self.refuses:
            self.refuses.remove(how)
            raise DaqFaultError("Dev1 was removed from the system", -200045)
        self.out.append((how, round(voltage_v, 9)))

    def put_now(self, voltage_v: float) -> None:
        self._put("now", voltage_v)

    def put(self, voltage_v: float) -> None:
        self._put("edge", voltage_v)

    def begin(self, voltage_v: float) -> None:
        self._put("begin", voltage_v)

    def take_over(self, voltage_v: float) -> None:
        self._put("reset", voltage_v)

    def clock_hz(self) -> float | None:
        return self.clock

    def release_card(self) -> None:
        self.released = True

    def close(self) -> None:
        self.closed = True
