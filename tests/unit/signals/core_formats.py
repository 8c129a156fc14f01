"""Suffixes of files from which a saved recording reads back the same."""

from __future__ import annotations

SAVED = [".h5", ".hdf5", ".csv"]
SAVED_WITHOUT_A_CLOCK = [".h5", ".csv"]
