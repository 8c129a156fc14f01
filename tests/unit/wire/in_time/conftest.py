"""What tests here import stands beside them, above and in benchmarks/; importlib mode puts none on the path."""

from __future__ import annotations

import sys
from pathlib import Path

from tests.places import BENCHMARKS, TESTS

sys.path.insert(0, str(Path(__file__).parent))
sys.path.insert(0, str(TESTS / "unit/wire"))
sys.path.insert(0, str(BENCHMARKS))
