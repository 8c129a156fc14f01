"""A simulated wire of several segments along its length, under conditions that change, with instruments of any kind."""

from musclewire.rigs.segmented.conditions import Conditions, ConditionsInTime, LocalDraughts, steady
from musclewire.rigs.segmented.device import SegmentedDevice, SegmentedSpool
from musclewire.rigs.segmented.instruments import InstrumentSettings
from musclewire.rigs.segmented.structure import Ageing, NormalMixture, WireStructure, mixture_distribution
from musclewire.rigs.segmented.wire import SegmentedState, SegmentedWire

__all__ = [
    "Ageing",
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
