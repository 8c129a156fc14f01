"""First of all: the gate's pin low, taken back from a pulse that may still run from before a soft reset."""

import musclewire_numbers as n
from machine import PWM, Pin

try:
    PWM(Pin(n.GATE_PIN)).deinit()
except (OSError, ValueError):
    pass  # no pulse has run on it
Pin(n.GATE_PIN, Pin.OUT, value=0)
