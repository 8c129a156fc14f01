"""Protection of a heated wire: one table of states, signals and events, and the functions that follow it."""

from musclewire.controllers._protection.protect import (
    ProtectionState,
    allowed_drive_v,
    armed,
    closed,
    protect_command,
    protect_event,
    protect_missing,
    protect_reading,
    rested,
    tripped_by,
)
from musclewire.controllers._protection.table import (
    Event,
    ProtectionLimits,
    ProtectionTable,
    Signal,
    State,
    protection_table,
)

__all__ = [
    "Event",
    "ProtectionLimits",
    "ProtectionState",
    "ProtectionTable",
    "Signal",
    "State",
    "allowed_drive_v",
    "armed",
    "closed",
    "protect_command",
    "protect_event",
    "protect_missing",
    "protect_reading",
    "protection_table",
    "rested",
    "tripped_by",
]
