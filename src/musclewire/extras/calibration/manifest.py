"""Wires by their physical numbers: calibrated, fitted from resistance alone, estimated by a particle filter."""

from __future__ import annotations

from musclewire.manifest import Command, Manifest

MANIFEST = Manifest(
    name="calibration",
    commands=(
        Command(
            "calibrate",
            "musclewire.extras.calibration._calibrate_command:calibrate",
            "Identify the physical parameters of your wire from recordings of it, with uncertainty.",
            panel="Recordings",
            before="recover",
            answer="musclewire.extras.calibration._answer:CalibrateAnswer",
        ),
    ),
    fits={"resistance alone": "musclewire.extras.calibration._fit_options:ResistanceOptions"},
    names={
        "Marks": "musclewire.extras.calibration._resistance_alone.observation:Marks",
        "calibrate": "musclewire.extras.calibration._physical.calibrate:calibrate",
        "channel_axes": "musclewire.extras.calibration._physical.calibration_report:channel_axes",
        "fit_resistance": "musclewire.extras.calibration._resistance_alone.fitting:fit_resistance",
        "next_experiments": "musclewire.extras.calibration._physical.advice:next_experiments",
        "save_wire": "musclewire.extras.calibration._physical.calibration:save_wire",
        "settings_of_effort": "musclewire.extras.calibration._physical.search:settings_of_effort",
        "write_report": "musclewire.extras.calibration._physical.calibration_report:write_report",
    },
    estimators={"particle-filter": "musclewire.extras.calibration._particles._estimator:particle_filter"},
    kernels=(
        "musclewire.extras.calibration._particles._cloud",
        "musclewire.extras.calibration._particles._kernel",
    ),
)
