"""Two clocks, of which neither is believed alone: a paced device's own, and that of the host."""

from __future__ import annotations

from collections import deque

# A difference that lasts is one that is found in two stretches of the host's time [s], one after the other.
STRETCH_S = 2.5
# Difference of the two over the longer time, with which they may go on: oscillators differ by far less.
MAX_DIFFERENCE = 0.1


class TwoClocks:
    """The times that a heated wire's samples cover, by the longer of two clocks, and whether the two differ for good.

    A late sample was not late at the device, and the next one comes the sooner: so the whole time since the drive was
    last at the sense voltage is compared, not each sample's.
    """

    def __init__(self) -> None:
        """Begin with a wire that is not heated."""
        self._heated_since_ns: int | None = None
        self._counted_s = 0.0
        self._stretch_ns: int | None = None
        self._device_s = 0.0
        self._slower = ""
        self._took_s: deque[float] = deque(maxlen=2)

    @property
    def expected_s(self) -> float:
        """How long the next sample may take [s], by the host's clock: as long as the shorter of the last two took."""
        return min(self._took_s, default=0.0)

    def rest(self) -> None:
        """Begin again after a pause at the sense voltage."""
        self._heated_since_ns = self._stretch_ns = None
        self._slower = ""

    def covered_s(self, device_s: float, heated: bool, ordered_ns: int, came_ns: int) -> float:
        """Return the time [s] that a sample covers: by the device's clock, or more by the host's if the wire is heated.

        ``ordered_ns`` is when its drive was ordered and ``came_ns`` when the sample had come, by the host's clock.
        """
        self._took_s.append(1e-9 * (came_ns - ordered_ns))
        if not heated:
            self._heated_since_ns = None
            return device_s
        if self._heated_since_ns is None:
            self._heated_since_ns, self._counted_s = ordered_ns, 0.0
        longer_s = max(device_s, 1e-9 * (came_ns - self._heated_since_ns) - self._counted_s)
        self._counted_s += longer_s
        return longer_s

    def difference(self, device_s: float, came_ns: int) -> str:
        """Return in words how the two differ for good; "" if they do not. ``device_s`` is the device's own step [s]."""
        if self._stretch_ns is None:
            self._stretch_ns, self._device_s = came_ns, 0.0
            return ""
        self._device_s += device_s
        device_s, host_s = self._device_s, 1e-9 * (came_ns - self._stretch_ns)
        if host_s < STRETCH_S:
            return ""
        slower = "device" if device_s < host_s else "host"
        if abs(device_s - host_s) <= MAX_DIFFERENCE * max(device_s, host_s):
            slower = ""
        lasting = slower != "" and slower == self._slower
        self._stretch_ns, self._device_s, self._slower = came_ns, 0.0, slower
        said = f"{device_s:.2f} s by the device's clock were {host_s:.2f} s by the host's, and so it was before"
        return said if lasting else ""
