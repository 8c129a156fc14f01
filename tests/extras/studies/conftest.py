from __future__ import annotations

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))  # for counting_runs, here and in local workers

from counted_study import Counted


@pytest.fixture
def counted(tmp_path: Path) -> Counted:
    return Counted(tmp_path)
