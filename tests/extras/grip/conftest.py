from __future__ import annotations

from pathlib import Path

import pytest
from tests.tools import made_once

from musclewire.extras.grip import GripperKnowledge, load_knowledge, train_gripper


@pytest.fixture(scope="session")
def learned(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The file of what a gripper has learned, as ``musclewire grip --learned FILE`` leaves it for the next grip."""

    def train(folder: Path) -> None:
        train_gripper("gripper", seed=1000).save(folder / "learned.json")

    return made_once(tmp_path_factory, "gripper", train) / "learned.json"


@pytest.fixture(scope="session")
def knowledge(learned: Path) -> GripperKnowledge:
    """What the gripper has learned."""
    return load_knowledge(learned)
