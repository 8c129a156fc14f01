"""What tests of pairs import stands beside them, with the core's tests of a wire and in benchmarks/."""

from __future__ import annotations

import sys
from pathlib import Path

from tests.places import BENCHMARKS, TESTS

sys.path.insert(0, str(Path(__file__).parent))
sys.path.insert(0, str(TESTS / "unit/wire"))
sys.path.insert(0, str(BENCHMARKS))
