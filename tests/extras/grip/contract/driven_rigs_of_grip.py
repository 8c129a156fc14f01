"""Rigs of this extra among those on which nothing may be compiled while the wire is driven."""

from __future__ import annotations

from tests.contract.simulated_rigs import pulling

from musclewire.rigs import open_rig

RIGS = (
    ("antagonist", pulling({"part": "antagonist", "voltage": "0.3 V"})),
    ("gripper", lambda: open_rig("gripper")),
)
