"""Studies of many wires, and estimators and controllers under disturbance."""

from __future__ import annotations

from musclewire.manifest import Command, Manifest

__all__ = ["MANIFEST"]

MANIFEST = Manifest(
    name="studies",
    commands=(
        Command(
            "sweep",
            "musclewire.extras.studies._sweep_command:sweep",
            "Run a study of many wires: on all cores, or on a Dask cluster.",
            panel="Studies and the paper",
            before="reproduce",
        ),
        Command(
            "robustness",
            "musclewire.extras.studies._robustness_command:robustness",
            "Compare estimators and controllers on a population of simulated wires under disturbance.",
            panel="Studies and the paper",
            before="reproduce",
        ),
    ),
    names={
        "RUN_KINDS": "musclewire.extras.studies:RUN_KINDS",
        "read_study": "musclewire.extras.studies:read_study",
        "read_study_data": "musclewire.extras.studies:read_study_data",
        "sweep": "musclewire.extras.studies:sweep",
        "write_study": "musclewire.extras.studies._study_page:write_study",
    },
    devices={"segmented": "musclewire.extras.studies._segmented.configuration:SEGMENTED"},
    schemas={"study": "musclewire.extras.studies._study_file:StudyFile"},
    outputs="musclewire.extras.studies:outputs",
    kernels=(
        "musclewire.extras.studies._segmented.kernel",
        "musclewire.extras.studies._segmented.solution",
        "musclewire.extras.studies._segmented.state",
    ),
)
