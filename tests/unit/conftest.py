"""The loop of the bench, as `open_rig("simulated")` and `characterize` give it: nobody can change a recording."""

from __future__ import annotations

import pytest

from musclewire.experiment import characterize
from musclewire.rigs import open_rig
from musclewire.signals import Recording


@pytest.fixture(scope="session")
def loop() -> Recording:
    with open_rig("simulated") as rig:
        return characterize(rig)
