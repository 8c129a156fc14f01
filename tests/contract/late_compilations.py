"""Drive one kind of rig in a process of its own, and print what was compiled while the wire was driven.

A function that is loaded from the cache counts, too: with an empty cache it would have been compiled there.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

from numba.core.dispatcher import Dispatcher
from tests.subjects import subjects_of

from musclewire.controllers import sampled_reference
from musclewire.experiment import (
    HeldVoltage,
    characterize,
    control,
    home,
    pretension_sweep,
    run_on_rig,
)
from musclewire.files import read_recording
from musclewire.identify import fit, tune
from musclewire.rigs import GuardedRig, ProtectionTripError, RigConfiguration, open_rig
from musclewire.sensing import load_model

AIR = {"draught": 0.2, "ambient_swing": 1.0}


RIGS: dict[str, Callable[[], GuardedRig]] = {
    "simulated": lambda: open_rig("simulated"),
    "real time": lambda: open_rig("simulated", real_time=True, clock_speed=100.0),
    "moving air": lambda: open_rig(RigConfiguration(surroundings=AIR)),
    "finger": lambda: open_rig("finger"),
    **dict(subjects_of("contract", "driven_*.py", "RIGS")),
}


def drive(rig: GuardedRig) -> None:
    """Hold a voltage, given as a whole number, then go to one that the protection refuses."""
    on_sample: Callable[[Any], None] = lambda _row: None  # noqa: E731  # so that samples are taken one by one
    with suppress(ProtectionTripError):
        run_on_rig(rig, HeldVoltage(1, rig.sense_voltage_v, rig.sample_period_s, 0.5), 2.0, on_sample=on_sample)
        rig.exchange(10 * rig.maximum_voltage_v)


def loop_and_model(folder: Path) -> None:
    """Make what a closed loop and a home move begin with."""
    with open_rig("simulated") as rig:
        loop = characterize(rig, period_s=60.0, path=folder / "loop.h5")
    fit(loop).save(folder / "model.json")


# Controllers that act by what they know of their wire.
OF_ITS_WIRE = ("inverse-model",)


def closed_loop(estimator: str, controller: str) -> Callable[[GuardedRig, Path], Any]:
    """Return a job that goes up and down a little."""

    def follow(rig: GuardedRig, folder: Path) -> None:
        model = load_model(folder / "model.json")
        settings = tune(model, read_recording(folder / "loop.h5")).settings if controller in OF_ITS_WIRE else None
        middle = 0.5 * (model.quantity_min + model.quantity_max)
        target = sampled_reference([0.0, 1.0, 2.0], [middle, 1.1 * middle, middle])
        control(rig, model, target, estimator=estimator, controller=controller, settings=settings, approach_s=1.0)

    return follow


JOBS: dict[str, Callable[[GuardedRig, Path], Any]] = {
    "drive": lambda rig, _folder: drive(rig),
    "characterize": lambda rig, _folder: characterize(rig, period_s=4.0, cycles=1),
    "sweep": lambda rig, _folder: pretension_sweep(rig, (1.0, 1.9), cycles=1),
    "home": lambda rig, folder: home(rig, load_model(folder / "model.json")),
    "filter": closed_loop("filter", "fuzzy-pid"),
    "polynomial": closed_loop("polynomial", "pid"),
    "inverse-model": closed_loop("filter", "inverse-model"),
}


def late_compilations(make: Callable[[], GuardedRig], job: Callable[[GuardedRig], Any]) -> list[str]:
    """Return the names of the functions that were compiled while the drive of a rig was not 0 V."""
    late: list[str] = []
    before: Any = Dispatcher.compile
    rigs: list[GuardedRig] = []

    def noting(dispatcher: Any, signature: Any) -> Any:
        known = len(dispatcher.overloads)
        result = before(dispatcher, signature)
        if len(dispatcher.overloads) > known and any(rig.drive_voltage_v != 0.0 for rig in rigs):
            late.append(f"{dispatcher.py_func.__module__}.{dispatcher.py_func.__name__}")
        return result

    Dispatcher.compile = noting
    with make() as rig:
        rigs.append(rig)
        job(rig)
    return late


def main(arguments: Sequence[str]) -> None:
    if arguments[0] == "model":
        loop_and_model(Path(arguments[1]))
        return
    rig, job, folder = arguments
    print(json.dumps(late_compilations(RIGS[rig], lambda opened: JOBS[job](opened, Path(folder)))))


if __name__ == "__main__":
    main(sys.argv[1:])
