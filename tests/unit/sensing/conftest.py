"""The wire of the bench, fitted once; the synthetic loops stand beside, where importlib mode does not look."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from musclewire.experiment import characterize
from musclewire.identify import fit
from musclewire.rigs import open_rig
from musclewire.sensing import SensingModel
from musclewire.signals import Recording

sys.path.insert(0, str(Path(__file__).parent))


@pytest.fixture(scope="package")
def loop() -> Recording:
    with open_rig("simulated", seed=1) as rig:
        return characterize(rig)


@pytest.fixture(scope="package")
def model(loop: Recording) -> SensingModel:
    return fit(loop)
