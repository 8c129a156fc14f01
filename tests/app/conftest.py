"""What the tests of commands share: a model of the simulated rig's wire."""

from __future__ import annotations

from pathlib import Path

import pytest

from musclewire.experiment import characterize
from musclewire.identify import fit
from musclewire.rigs import open_rig


@pytest.fixture(scope="session")
def model(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The file of a model that one cycle of the simulated rig gave."""
    path = tmp_path_factory.mktemp("model") / "model.json"
    with open_rig("simulated") as rig:
        fit(characterize(rig, cycles=1)).save(path)
    return path
