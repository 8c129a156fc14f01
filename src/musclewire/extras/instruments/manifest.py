"""What this extra offers."""

from __future__ import annotations

from musclewire.manifest import Manifest

MANIFEST = Manifest(
    name="instruments",
    rig_keys={
        "fault": "musclewire.extras.instruments._faults:FAULTS",
        "pwm": "musclewire.extras.instruments._pulse_width:PULSES",
    },
)
