"""The circuit: a MOSFET switched by pulse width, a current monitor on I2C, the host's line, the watchdog."""

import math
import time

import musclewire_line
import musclewire_numbers as n
from machine import I2C, PWM, WDT, WDT_RESET, Pin, reset_cause

FULL = 65535


class SwitchedCircuit:
    """What the program may do with the circuit."""

    def __init__(self):
        self.gate = PWM(Pin(n.GATE_PIN), freq=n.PULSE_HZ, duty_u16=0)
        # A bus that hangs must not hold the gate open: what waits on it ends in two milliseconds.
        self.i2c = I2C(n.I2C_BUS, sda=Pin(n.SDA_PIN), scl=Pin(n.SCL_PIN), freq=400_000, timeout=2000)
        self.line, self.watchdog = musclewire_line.Line(), None
        self.drive_v, self.duty, self.read_s = 0.0, 0, n.READING_S
        self.due, self.seen_v = 1.0, (0.0, 0.0)
        self.reset_cause = n.RESET_WATCHDOG if reset_cause() == WDT_RESET else n.RESET_POWER_ON

    def received(self):
        return self.line.received()

    def send(self, frame):
        self.line.send(frame)

    def watch(self, armed):
        """Feed the watchdog, once a finished tick; it begins when the wire is first armed, for nothing stops it."""
        if armed and self.watchdog is None:
            self.watchdog = WDT(timeout=n.WATCHDOG_MS)
        if self.watchdog is not None:
            self.watchdog.feed()

    def set_drive(self, drive_v):
        """Heat as a steady drive voltage would: by the reading's pulse, and by pulses of the timer after it."""
        self.drive_v = drive_v
        rest = ((drive_v / n.SUPPLY_V) ** 2 * n.TICK_S - self.read_s) / (n.TICK_S - self.read_s)
        self.duty = round(FULL * min(max(rest, 0.0), 1.0)) if drive_v else 0
        self.gate.duty_u16(self.duty)

    def switch_off(self):
        """Nothing is out, whatever has happened."""
        self.drive_v, self.duty = 0.0, 0
        self.gate.duty_u16(0)

    def close(self):
        """Switch off, and give the line back."""
        self.switch_off()
        self.line.close()

    def _register(self, register, count):
        return int.from_bytes(self.i2c.readfrom_mem(n.MONITOR_ADDRESS, register, count), "big")

    def reading(self, armed):
        """Return wire and shunt voltage [V] as of a steady drive, None if the monitor gives none in time.

        The monitor sees the supply's full voltage; what heats is the root mean square of a tick's pulses. Where no
        current is expected yet, below half the sense voltage, a pulse comes in as many ticks as the drive is worth.
        """
        if not armed or not self.drive_v:
            return 0.0, 0.0
        part = math.sqrt((self.read_s + self.duty / FULL * (n.TICK_S - self.read_s)) / n.TICK_S)
        if self.drive_v < 0.5 * n.SENSE_V:
            part = self.drive_v / n.SUPPLY_V
            self.due += part * part * n.TICK_S / self.read_s
            if self.due < 1.0:
                return part * self.seen_v[0], part * self.seen_v[1]
            self.due = min(self.due - 1.0, 1.0)
        found, began = None, time.ticks_us()
        self.gate.duty_u16(FULL)
        try:
            # While this is sent, for 90 us, the pulse begins, with its next period, and leads and supply settle.
            self.i2c.writeto_mem(n.MONITOR_ADDRESS, n.CONFIGURATION, n.TRIGGER)
            time.sleep_us(n.CONVERSIONS_US)
            self._pulse_ends(began)
            found = self._converted()
        except OSError:
            self._pulse_ends(began)  # no monitor at this address
        if found is None:
            return None
        bus_v, shunt_v = found
        self.seen_v = (bus_v - shunt_v / n.RULES[n.SHUNT_OHM] * n.BESIDE_WIRE_OHM, shunt_v)
        return part * self.seen_v[0], part * self.seen_v[1]

    def _pulse_ends(self, began):
        """Go on by the drive; whatever is read of the monitor after this was converted before."""
        self.gate.duty_u16(self.duty)
        self.read_s = min(time.ticks_diff(time.ticks_us(), began) * 1e-6, 0.5 * n.TICK_S)

    def _converted(self):
        """Return bus and shunt voltage [V] of one conversion of each, None if they are not ready or out of range."""
        ready = self._register(n.READY_REGISTER, n.READY_BYTES) & n.READY_MASK
        bus, shunt = self._register(n.BUS_REGISTER, n.BUS_BYTES), self._register(n.SHUNT_REGISTER, n.SHUNT_BYTES)
        if not ready or bus & n.OVERFLOW_MASK:
            return None
        bits = 8 * n.SHUNT_BYTES
        shunt -= (shunt >> (bits - 1)) << bits
        return (bus >> n.BUS_SHIFT) * n.BUS_STEP_V, (shunt >> n.SHUNT_SHIFT) * n.SHUNT_STEP_V
