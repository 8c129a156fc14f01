"""Ctrl-C at 500 random moments of each kind of rig: what ``test_rig_contract.py`` tries at 20."""

from __future__ import annotations

from pathlib import Path

import pytest
from tests.contract.rig_subject import RigSubject
from tests.contract.test_rig_contract import SUBJECTS, interrupt_at

from musclewire.rigs import Rig

pytestmark = [
    pytest.mark.full,
    pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning"),
]


@pytest.fixture(params=SUBJECTS, ids=lambda subject: subject.name)
def subject(request: pytest.FixtureRequest) -> RigSubject:
    found: RigSubject = request.param
    return found


@pytest.fixture
def rig(subject: RigSubject, request: pytest.FixtureRequest, tmp_path: Path) -> Rig:
    return subject.opened(request, tmp_path)


def test_ctrl_c_at_500_random_moments_leaves_no_drive_on(
    rig: Rig, subject: RigSubject, request: pytest.FixtureRequest, tmp_path: Path
) -> None:
    interrupt_at(500, rig, lambda: subject.opened(request, tmp_path), by_the_clock=subject.by_the_clock)
