"""Pins, pulses, I2C and watchdog of an emulated board, and the current monitor on its bus.

The bench gives the voltages within a pulse, which the monitor sees while the gate is on; it is told the mean drive.
"""

import binascii
import json
import math

import bench
import bench_time

circuit = json.loads(bench.circuit)
CONVERSION, CONVERTING, OUTPUT, OUTPUT_AT_START = 0xA5, 0x5A, 0x3C, 0x3D
FULL = 65535
PACKET = 7  # bytes of a conversion
BYTE_US = 23  # of a byte on I2C at 400 kHz
WDT_RESET, PWRON_RESET = 3, 1


class Pins:
    """The two sides of the output stage, and what this tick's pulses are."""

    def __init__(self):
        self.part = bytearray()
        self.kind, self.number, self.answered = OUTPUT_AT_START, 0, 0
        self.duty, self.on_us, self.on_since, self.off_since = 0, 0, None, 0
        self.node_v = self.shunt_v = 0.0
        self.watchdog_us = self.fed_us = 0

    def mean_part(self):
        """Return the part of a tick in which the gate is on."""
        on_us = min(self.on_us, circuit["tick_us"])
        return (on_us + self.duty / FULL * (circuit["tick_us"] - on_us)) / circuit["tick_us"]

    def turn_ended(self):
        """Tell the bench that a conversion was answered, and take the next one."""
        if self.kind == OUTPUT_AT_START or self.answered != self.number:
            self.answered = self.number
            self.tell()
        self.part.extend(bytes(int(each) for each in bench.pins_take().split()))
        while self.part and self.part[0] != CONVERSION:
            self.part = self.part[1:]
        if len(self.part) >= PACKET:
            self._convert(self.part[1:PACKET])
            self.part = self.part[PACKET:]

    def tell(self):
        """Tell the bench what is out; an answer to the host comes after it."""
        out_v = math.sqrt(self.mean_part()) * circuit["supply_v"]
        code = round(out_v / circuit["output_range_v"] * circuit["output_full"])
        packet = [self.kind, code & 255, code >> 8, self.answered]
        packet.append(packet[0] ^ packet[1] ^ packet[2] ^ packet[3])
        self.kind = OUTPUT
        bench.pins_send(binascii.hexlify(bytes(packet)).decode())

    def _convert(self, packet):
        """A tick has passed: take the voltages of its drive."""
        full = (1 << circuit["bench_bits"]) - 1
        volts = [(packet[at] + 256 * packet[at + 1]) / full * circuit["converter_range_v"] for at in (0, 2)]
        self.node_v, self.shunt_v = volts[0] / circuit["divider_share"], volts[1] / circuit["shunt_gain"]
        self.number = packet[4]
        self.on_us = 0
        bench_time.clock_us += circuit["tick_us"] - bench_time.clock_us % circuit["tick_us"]
        if self.watchdog_us and bench_time.clock_us - self.fed_us > self.watchdog_us:
            bench.reset(WDT_RESET)


pins = Pins()


def reset_cause():
    return bench.cause()


class Pin:
    OUT = 1

    def __init__(self, number, mode=None, value=None):
        self.number = number


class PWM:
    def __init__(self, pin, freq=0, duty_u16=0):
        self.duty_u16(duty_u16)

    def duty_u16(self, duty):
        if duty == FULL:
            pins.on_since = bench_time.clock_us
        elif pins.on_since is not None:
            pins.on_us += bench_time.clock_us - pins.on_since
            pins.off_since, pins.on_since = bench_time.clock_us, None
        changed, pins.duty = duty != pins.duty and duty != FULL, duty
        if changed and pins.kind == OUTPUT:
            pins.tell()

    def deinit(self):
        self.duty_u16(0)


class WDT:
    def __init__(self, timeout):
        pins.watchdog_us = 1000 * timeout
        self.feed()

    def feed(self):
        pins.fed_us = bench_time.clock_us


class I2C:
    """A bus with an INA219."""

    def __init__(self, number, sda, scl, freq, timeout):
        self.configuration, self.began_us = 0x399F, 0

    def writeto_mem(self, address, register, value):
        bench_time.clock_us += (2 + len(value)) * BYTE_US
        if address != circuit["monitor_address"]:
            raise OSError(5)
        self.began_us = bench_time.clock_us

    def readfrom_mem(self, address, register, count):
        bench_time.clock_us += (3 + count) * BYTE_US
        if address != circuit["monitor_address"]:
            raise OSError(5)
        # What it shows was converted while the gate was on, or not.
        converted_us = self.began_us + circuit["conversion_us"]
        on = pins.on_since is not None or pins.off_since >= converted_us
        shunt_v = pins.shunt_v if on else 0.0
        wire_v = pins.node_v - pins.shunt_v if on else 0.0
        bus_v = wire_v + shunt_v / circuit["shunt_ohm"] * circuit["beside_wire_ohm"]
        ready = 2 if bench_time.clock_us >= converted_us else 0
        found = (self.configuration, round(shunt_v / 10e-6) & 0xFFFF, max(round(bus_v / 4e-3), 0) << 3 | ready)[
            register
        ]
        return found.to_bytes(count, "big")
