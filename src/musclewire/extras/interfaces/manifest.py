"""The simulated wire for programs that others already use: Gymnasium, python-control, FMI."""

from __future__ import annotations

from musclewire.manifest import Command, Manifest

MANIFEST = Manifest(
    name="interfaces",
    commands=(
        Command(
            "linearise",
            "musclewire.extras.interfaces._linearise_command:linearise",
            "Linearise the simulated wire at a displacement: operating points, poles, margins of the closed loop.",
            panel="Choose, simulate and design",
            before="design",
            answer="musclewire.extras.interfaces._linearise_command:LineariseAnswer",
        ),
        Command(
            "fmu",
            "musclewire.extras.interfaces._export_fmu_command:export_fmu",
            "Wire or controller as a functional mock-up unit (FMI 2.0, co-simulation) with its C sources and a binary.",
            group="export",
            answer="musclewire.extras.interfaces._export_fmu_command:ExportFmuAnswer",
        ),
    ),
    names={
        "export_fmu": "musclewire.extras.interfaces._fmu:export_fmu",
        "WireVectorEnv": "musclewire.extras.interfaces._environments.vector:WireVectorEnv",
        "branch_system": "musclewire.extras.interfaces._control_systems.systems:branch_system",
        "linear_system": "musclewire.extras.interfaces._control_systems.systems:linear_system",
        "linearise": "musclewire.extras.interfaces._control_systems.study:linearise",
        "loop_margins": "musclewire.extras.interfaces._control_systems.loops:loop_margins",
        "operating_point": "musclewire.extras.interfaces._control_systems.operating_points:operating_point",
        "wire_system": "musclewire.extras.interfaces._control_systems.systems:wire_system",
    },
    kernels=(
        "musclewire.extras.interfaces._control_systems.heating",
        "musclewire.extras.interfaces._environments.kernels",
    ),
)
