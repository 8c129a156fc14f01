"""Studies of many wires, and wires in segments."""

from __future__ import annotations

from musclewire.manifest import Command, Manifest

MANIFEST = Manifest(
    name="studies",
    commands=(
        Command(
            "sweep",
            "musclewire.extras.studies._sweep_command:sweep",
            "Run a study of many wires: on all cores, or on a Dask cluster.",
            panel="Studies and the paper",
            before="reproduce",
            answer="musclewire.extras.studies._answers:SweepAnswers",
        ),
    ),
    names={
        "Conditions": "musclewire.extras.studies._segmented.conditions:Conditions",
        "InstrumentSettings": "musclewire.extras.studies._segmented.instruments:InstrumentSettings",
        "KindOptions": "musclewire.extras.studies._run_kind:KindOptions",
        "Quantity": "musclewire.extras.studies._run_kind:Quantity",
        "RunKind": "musclewire.extras.studies._run_kind:RunKind",
        "RunningInstruments": "musclewire.extras.studies._segmented.instruments:RunningInstruments",
        "SegmentedDevice": "musclewire.extras.studies._segmented.device:SegmentedDevice",
        "SegmentedSpool": "musclewire.extras.studies._segmented.device:SegmentedSpool",
        "WireStructure": "musclewire.extras.studies._segmented.structure:WireStructure",
        "each": "musclewire.extras.studies._run_kind:each",
        "on_grid": "musclewire.extras.studies._data_set:on_grid",
        "steady": "musclewire.extras.studies._segmented.conditions:steady",
        "RUN_KINDS": "musclewire.extras.studies:RUN_KINDS",
        "read_study": "musclewire.extras.studies:read_study",
        "read_study_data": "musclewire.extras.studies:read_study_data",
        "sweep": "musclewire.extras.studies:sweep",
        "write_study": "musclewire.extras.studies._study_page:write_study",
    },
    devices={"segmented": "musclewire.extras.studies._segmented.configuration:SEGMENTED"},
    schemas={"study": "musclewire.extras.studies._study_file:StudyFile"},
    kernels=("musclewire.extras.studies._segmented.kernel",),
)
