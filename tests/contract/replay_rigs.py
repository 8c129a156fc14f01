"""The replay of the contract suite: every test runs twice, first on a rig that is recorded, then on that recording.

A replay answers only to what was driven when its recording was made. So the recording is made by the test itself: its
body runs on the simulated rig, whose samples are written to a file, and then, unchanged, on the replay of the file.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.contract.altered_device import AlteredDevice
from tests.contract.rig_subject import PAPERS_WIRE_OHM, Opened, RigSubject
from tests.contract.simulated_rigs import SHORT_OHM

from musclewire.experiment import what_protects
from musclewire.rigs import Answer, GuardedRig, open_rig
from musclewire.signals import ELECTRICAL_COLUMNS, RawSample, Recording


def noting(rig: GuardedRig) -> list[RawSample]:
    """Return a list that will hold every sample of a rig, also one at which the protection trips."""
    noted: list[RawSample] = []

    def note(answer: Answer) -> Answer:
        if isinstance(answer, RawSample):
            noted.append(answer)
        return answer

    rig.device = AlteredDevice(rig.device, note)
    return noted


def recording_of(samples: list[RawSample], rig: GuardedRig, metadata: dict[str, Any]) -> Recording:
    """Return samples as a recording, with the columns the rig has."""
    names = [*ELECTRICAL_COLUMNS, *(rig.reference_columns or ())]
    columns = {name: np.array([getattr(sample, name) for sample in samples], dtype=np.float64) for name in names}
    return Recording(columns, {**metadata, "ended": "done"})


def replayed(make: Callable[[], GuardedRig], request: pytest.FixtureRequest, folder: Path) -> GuardedRig:
    """Run the requesting test on a rig that is recorded; return the replay of the recording for its second run."""
    recorded = make()
    metadata = {**what_protects(recorded), **recorded.metadata()}
    samples = noting(recorded)
    test = request.function
    parametrized = getattr(request.node, "callspec", None)
    known = {} if parametrized is None else parametrized.params
    arguments = {
        name: known[name] if name in known else request.getfixturevalue(name)
        for name in inspect.signature(test).parameters
        if name != "rig"
    }
    test(rig=recorded, **arguments)
    recording_of(samples, recorded, metadata).save(folder / "recorded.h5")
    rig_file = folder / "replay.toml"
    rig_file.write_text('kind = "replay"\nrecording = "recorded.h5"\n', encoding="utf-8")
    return open_rig(rig_file)


def replay_of(name: str) -> Opened:
    """Return what opens the replay of a rig that is known by name."""
    return lambda request, folder: replayed(lambda: open_rig(name), request, folder)


SUBJECTS = (
    RigSubject("replay", replay_of("simulated"), PAPERS_WIRE_OHM),
    RigSubject("replay of a finger", replay_of("finger"), SHORT_OHM),
)
