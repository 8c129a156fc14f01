"""The simulated wire for programs that others already use: Gymnasium, python-control, FMI."""

from __future__ import annotations

from musclewire.manifest import Command, Manifest

__all__ = ["MANIFEST"]

MANIFEST = Manifest(
    name="interfaces",
    commands=(
        Command(
            "linearise",
            "musclewire.extras.interfaces._linearise_command:linearise",
            "Linearise the simulated wire at a displacement: operating points, poles, margins of the closed loop.",
            panel="Choose, simulate and design",
            before="design",
        ),
        Command(
            "fmu",
            "musclewire.extras.interfaces._export_fmu_command:export_fmu",
            "Wire or controller as a functional mock-up unit (FMI 2.0, co-simulation) with its C sources and a binary.",
            group="export",
        ),
    ),
    names={"export_fmu": "musclewire.extras.interfaces._fmu:export_fmu"},
    outputs="musclewire.extras.interfaces:outputs",
    kernels=(
        "musclewire.extras.interfaces._control_systems.heating",
        "musclewire.extras.interfaces._environments.kernels",
    ),
)
