"""What the tests of judging share: a model of the simulated wire."""

from __future__ import annotations

import pytest

import musclewire as mw
from musclewire.sensing import SensingModel


@pytest.fixture(scope="session")
def model() -> SensingModel:
    """A model of the simulated wire with the gains that ``fit`` finds."""
    with mw.open_rig("simulated", seed=3) as rig:
        return mw.fit(mw.characterize(rig))
