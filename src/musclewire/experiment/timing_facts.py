"""How punctual a run was, as its recording states it: percentiles in the metadata, and the same as JSON keys."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.signals.recording import MetadataValue

__all__ = ["percentiles", "timing_json"]

PERCENTILES = {"p50": 50.0, "p99": 99.0, "p999": 99.9}


def percentiles(name: str, values_us: FloatArray) -> dict[str, MetadataValue]:
    """Return the percentiles of times [us] under the names of metadata; none without times."""
    if not values_us.size:
        return {}
    found = np.percentile(values_us, list(PERCENTILES.values()))
    return {f"{name}_{key}_us": round(float(value), 1) for key, value in zip(PERCENTILES, found, strict=True)}


def timing_json(metadata: Mapping[str, MetadataValue]) -> dict[str, Any]:
    """Return the timing in a recording's metadata as JSON keys; None for what was not measured."""
    found: dict[str, Any] = {"deadline_misses": metadata.get("deadline_misses", 0)}
    for name in ("jitter", "latency", "compute"):
        parts = {key: metadata.get(f"{name}_{key}_us") for key in PERCENTILES}
        found[f"{name}_us"] = None if None in parts.values() else parts
    return {**found, "drift_us": metadata.get("drift_us")}
