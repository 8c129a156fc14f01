"""Suffixes of files of other programs from which a saved recording reads back the same."""

from __future__ import annotations

SAVED = [".parquet", ".mat"]
SAVED_WITHOUT_A_CLOCK = [".parquet", ".mat", ".xlsx"]
