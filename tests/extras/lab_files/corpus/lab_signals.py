"""The short run that every file of the corpus of laboratory programs holds, and files as these programs write them."""

from __future__ import annotations

import numpy as np

ROWS = 60
PERIOD_S = 0.05
TIME_S = np.arange(ROWS) * PERIOD_S
# A wire that is heated and cooled once: voltages, displacement and force of a plausible size.
_HEAT = np.sin(np.pi * TIME_S / TIME_S[-1]) ** 2
WIRE_VOLTAGE_V = np.round(0.30 + 2.4 * _HEAT, 6)
SHUNT_VOLTAGE_V = np.round(0.02 + 0.17 * _HEAT, 6)
DISPLACEMENT_MM = np.round(5.6 * _HEAT, 6)
FORCE_N = np.round(1.7 + 0.6 * _HEAT, 6)
