"""Gripping without a sensor: contact and force of fingers, from their wires' voltages."""

from __future__ import annotations

from musclewire.manifest import Command, Manifest

MANIFEST = Manifest(
    name="grip",
    commands=(
        Command(
            "grip",
            "musclewire.extras.grip._grip_command:grip",
            "Close fingers on an object, find contact and hold a force, all by the wires' resistance.",
            panel="The basic loop: record, fit, move",
            answer="musclewire.extras.grip._answer:GripAnswer",
        ),
    ),
    names={
        "GripperKnowledge": "musclewire.extras.grip._gripper_training:GripperKnowledge",
        "KnownGrip": "musclewire.extras.grip._contact_fitting:KnownGrip",
        "close_fingers": "musclewire.extras.grip._gripper_training:close_fingers",
        "fit_free_closing": "musclewire.extras.grip._contact_fitting:fit_free_closing",
        "fit_grip_curve": "musclewire.extras.grip._contact_fitting:fit_grip_curve",
        "grip": "musclewire.extras.grip._grip:grip",
        "gripper_of": "musclewire.extras.grip._gripper_training:gripper_of",
        "with_object": "musclewire.extras.grip._gripper_training:with_object",
    },
    load_parts={
        "antagonist": "musclewire.extras.grip._second_wires:Antagonist",
        "parallel wire": "musclewire.extras.grip._second_wires:ParallelWire",
        "second finger": "musclewire.extras.grip._second_wires:SecondFinger",
    },
    rig_files="musclewire.extras.grip:rig_files",
    kernels=("musclewire.extras.grip._coupling", "musclewire.extras.grip._pairs"),
    schemas={"gripper": "musclewire.extras.grip._gripper_training:GripperFile"},
)
