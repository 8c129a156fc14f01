"""What tests here import stands beside them and in benchmarks/; importlib mode puts neither folder on the path."""

from __future__ import annotations

import sys
from pathlib import Path

from tests.places import BENCHMARKS

sys.path.insert(0, str(Path(__file__).parent))
sys.path.insert(0, str(BENCHMARKS))
