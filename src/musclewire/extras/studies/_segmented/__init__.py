"""A simulated wire of several segments along its length, under conditions that change, with instruments of any kind."""

from musclewire.extras.studies._segmented.conditions import Conditions, ConditionsInTime, LocalDraughts, steady
from musclewire.extras.studies._segmented.device import SegmentedDevice, SegmentedSpool
from musclewire.extras.studies._segmented.instruments import InstrumentSettings
from musclewire.extras.studies._segmented.structure import (
    NormalMixture,
    WireAgeing,
    WireStructure,
    mixture_distribution,
)
from musclewire.extras.studies._segmented.wire import SegmentedState, SegmentedWire

__all__ = [
    "WireAgeing",
    "Conditions",
    "ConditionsInTime",
    "InstrumentSettings",
    "LocalDraughts",
    "NormalMixture",
    "SegmentedDevice",
    "SegmentedSpool",
    "SegmentedState",
    "SegmentedWire",
    "WireStructure",
    "mixture_distribution",
    "steady",
]
