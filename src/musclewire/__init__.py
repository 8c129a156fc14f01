"""Position and force control of shape-memory-alloy wires from their own electrical resistance.

    import musclewire as mw

    with mw.open_rig("simulated") as rig:
        loop = mw.characterize(rig)
        model = mw.fit(loop)
        run = mw.control(rig, model, mw.staircase())
    print(run.metrics)

Names are loaded when they are first used, so that importing the package costs nothing.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from musclewire.controllers import (
        CONTROLLERS,
        FuzzyPidSettings,
        SteeredReference,
        load_gains,
        sampled_reference,
        staircase,
    )
    from musclewire.errors import MusclewireError
    from musclewire.experiment.closed_loop import control
    from musclewire.experiment.home import home
    from musclewire.experiment.many_loops import control_many
    from musclewire.experiment.open_loop import characterize
    from musclewire.experiment.pretension import pretension_sweep
    from musclewire.experiment.speed_limits import speed_limits
    from musclewire.experiment.training import train
    from musclewire.experiment.zero_tendon import zero_tendon
    from musclewire.identify import estimate, fit
    from musclewire.identify.physical.calibrate import calibrate
    from musclewire.identify.resistance_alone.fitting import fit_resistance
    from musclewire.identify.resistance_alone.marks import Marks
    from musclewire.identify.tuning import tune
    from musclewire.rigs.configuration import open_rig
    from musclewire.rigs.kinds import DEVICES
    from musclewire.rigs.load_kinds import LOAD_PARTS
    from musclewire.sensing import ESTIMATORS, SensingModel, load_model
    from musclewire.signals import Recording, read_recording
    from musclewire.signals.runs_on_disk import recover_recording

__all__ = [
    "open_rig",
    "characterize",
    "fit",
    "fit_resistance",
    "Marks",
    "control",
    "control_many",
    "staircase",
    "sampled_reference",
    "SteeredReference",
    "estimate",
    "pretension_sweep",
    "zero_tendon",
    "train",
    "home",
    "calibrate",
    "tune",
    "speed_limits",
    "load_gains",
    "reproduce",
    "sweep",
    "read_study",
    "write_study",
    "read_study_data",
    "export_fmu",
    "read_recording",
    "recover_recording",
    "load_model",
    "Recording",
    "SensingModel",
    "FuzzyPidSettings",
    "ESTIMATORS",
    "CONTROLLERS",
    "DEVICES",
    "LOAD_PARTS",
    "RUN_KINDS",
    "LiveClient",
    "MusclewireError",
]

_HOMES = {
    "open_rig": "musclewire.rigs.configuration",
    "characterize": "musclewire.experiment.open_loop",
    "fit": "musclewire.identify",
    "fit_resistance": "musclewire.identify.resistance_alone.fitting",
    "Marks": "musclewire.identify.resistance_alone.marks",
    "control": "musclewire.experiment.closed_loop",
    "control_many": "musclewire.experiment.many_loops",
    "staircase": "musclewire.controllers",
    "sampled_reference": "musclewire.controllers",
    "SteeredReference": "musclewire.controllers",
    "estimate": "musclewire.identify",
    "pretension_sweep": "musclewire.experiment.pretension",
    "zero_tendon": "musclewire.experiment.zero_tendon",
    "train": "musclewire.experiment.training",
    "home": "musclewire.experiment.home",
    "speed_limits": "musclewire.experiment.speed_limits",
    "tune": "musclewire.identify.tuning",
    "load_gains": "musclewire.controllers.gains",
    "calibrate": "musclewire.identify.physical.calibrate",
    "read_recording": "musclewire.signals",
    "recover_recording": "musclewire.signals.runs_on_disk",
    "load_model": "musclewire.sensing",
    "Recording": "musclewire.signals",
    "SensingModel": "musclewire.sensing",
    "FuzzyPidSettings": "musclewire.controllers",
    "CONTROLLERS": "musclewire.controllers",
    "ESTIMATORS": "musclewire.sensing",
    "DEVICES": "musclewire.rigs.kinds",
    "LOAD_PARTS": "musclewire.rigs.load_kinds",
    "MusclewireError": "musclewire.errors",
}


def __getattr__(name: str) -> Any:
    """Load a public name from its home on first use; ``__version__`` is that of the installed package."""
    if name == "__version__":
        from importlib.metadata import version

        return version("musclewire")
    value = getattr(import_module(_HOMES[name]), name) if name in _HOMES else _name_of_a_part(name)
    globals()[name] = value
    return value


def _name_of_a_part(name: str) -> Any:
    """Return a name that a part outside the core offers; AttributeError tells of a part that is not there."""
    from musclewire.manifest import absent_part, loaded, offered

    place = offered("names").get(name)
    if place is not None:
        return loaded(place)
    absent = absent_part("names", name)
    raise AttributeError(str(absent) if absent else f"module 'musclewire' has no attribute '{name}'")


def __dir__() -> list[str]:
    """Return the public names."""
    return sorted(__all__)
