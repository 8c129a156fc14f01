"""Rigs of this extra among those on which nothing may be compiled while the wire is driven."""

from __future__ import annotations

from musclewire.rigs import RigConfiguration, open_rig

PULSES = {"frequency": "100 Hz", "supply": "5 V", "sample_delay": "50 us"}
OPEN = {"kind": "wire_open", "at": "1 s"}
RIGS = (
    ("pulse width", lambda: open_rig(RigConfiguration(pwm=PULSES))),
    ("faults", lambda: open_rig(RigConfiguration(fault=[OPEN]))),
)
