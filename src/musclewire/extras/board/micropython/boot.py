"""First of all: the gate's pin low, taken back from a pulse that may still run from before a soft reset."""

import musclewire_numbers as n
from machine import PWM, Pin

Pin(n.GATE_PIN, Pin.OUT, value=0)
# Without its duty an ESP32's begins with half of it (micropython#8306).
PWM(Pin(n.GATE_PIN), freq=n.PULSE_HZ, duty_u16=0).deinit()
Pin(n.GATE_PIN, Pin.OUT, value=0)
