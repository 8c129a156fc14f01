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
    from musclewire.experiment import (
        characterize,
        control,
        control_many,
        home,
        pretension_sweep,
        speed_limits,
        train,
        zero_tendon,
    )
    from musclewire.identify import Marks, calibrate, estimate, fit, fit_resistance, tune
    from musclewire.rigs import DEVICES, LOAD_PARTS, open_rig
    from musclewire.sensing import ESTIMATORS, SensingModel, load_model
    from musclewire.signals import Recording, read_recording, recover_recording

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
    "open_rig": "musclewire.rigs._configuration",
    "characterize": "musclewire.experiment._open_loop",
    "fit": "musclewire.identify",
    "fit_resistance": "musclewire.identify._resistance_alone.fitting",
    "Marks": "musclewire.identify._resistance_alone.marks",
    "control": "musclewire.experiment._closed_loop",
    "control_many": "musclewire.experiment._many_loops",
    "staircase": "musclewire.controllers",
    "sampled_reference": "musclewire.controllers",
    "SteeredReference": "musclewire.controllers",
    "estimate": "musclewire.identify",
    "pretension_sweep": "musclewire.experiment._pretension",
    "zero_tendon": "musclewire.experiment._zero_tendon",
    "train": "musclewire.experiment._training",
    "home": "musclewire.experiment._home",
    "speed_limits": "musclewire.experiment._speed_limits",
    "tune": "musclewire.identify._tuning",
    "load_gains": "musclewire.controllers._gains",
    "calibrate": "musclewire.identify._physical.calibrate",
    "read_recording": "musclewire.signals",
    "recover_recording": "musclewire.signals._runs_on_disk",
    "load_model": "musclewire.sensing",
    "Recording": "musclewire.signals",
    "SensingModel": "musclewire.sensing",
    "FuzzyPidSettings": "musclewire.controllers",
    "CONTROLLERS": "musclewire.controllers",
    "ESTIMATORS": "musclewire.sensing",
    "DEVICES": "musclewire.rigs._kinds",
    "LOAD_PARTS": "musclewire.rigs._load_kinds",
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
