"""A simulated wire of several segments along its length, under conditions that change, with instruments of any kind."""

from musclewire.extras.studies.segmented.conditions import Conditions, ConditionsInTime, LocalDraughts, steady
from musclewire.extras.studies.segmented.device import SegmentedDevice, SegmentedSpool
from musclewire.extras.studies.segmented.instruments import InstrumentSettings
from musclewire.extras.studies.segmented.structure import NormalMixture, WireAgeing, WireStructure, mixture_distribution
from musclewire.extras.studies.segmented.wire import SegmentedState, SegmentedWire

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
