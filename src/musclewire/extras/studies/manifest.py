"""Studies of many wires, and estimators and controllers under disturbance."""

from __future__ import annotations

from musclewire.manifest import Command, Manifest

__all__ = ["MANIFEST"]

MANIFEST = Manifest(
    name="studies",
    commands=(
        Command(
            "sweep",
            "musclewire.app.sweep_command:sweep",
            "Run a study of many wires: on all cores, or on a Dask cluster.",
            panel="Studies and the paper",
            before="reproduce",
        ),
        Command(
            "robustness",
            "musclewire.app.robustness_command:robustness",
            "Compare estimators and controllers on a population of simulated wires under disturbance.",
            panel="Studies and the paper",
            before="reproduce",
        ),
    ),
    names={
        "RUN_KINDS": "musclewire.studies:RUN_KINDS",
        "read_study": "musclewire.studies:read_study",
        "read_study_data": "musclewire.studies:read_study_data",
        "sweep": "musclewire.studies:sweep",
        "write_study": "musclewire.studies.study_page:write_study",
    },
    devices={"segmented": "musclewire.rigs.segmented.configuration:SEGMENTED"},
    schemas={"study": "musclewire.studies.study_file:StudyFile"},
    kernels=(
        "musclewire.rigs.segmented.kernel",
        "musclewire.rigs.segmented.solution",
        "musclewire.rigs.segmented.state",
    ),
)
