"""Types of arrays of numbers for the annotations of all rooms; docstrings state shape and unit."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
