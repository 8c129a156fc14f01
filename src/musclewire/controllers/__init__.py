"""Fuzzy-tuned PID, drive limits and target trajectories: state in, state out; no clock, no hardware.

A controller takes a number, so it runs alike on a sensor and on an estimate from the wire's own resistance.
"""

from musclewire.controllers.controller import (
    CONTROLLERS,
    CompiledController,
    Controller,
    ControllerFactory,
    ControllerSetup,
)
from musclewire.controllers.drive_limits import DriveLimits
from musclewire.controllers.feedforward import FeedforwardController, FeedforwardSettings
from musclewire.controllers.fuzzy import FuzzyRatios, RatioSurface, infer_ratios, infer_surface
from musclewire.controllers.fuzzy_pid import ControllerState, FuzzyPid, FuzzyPidController, FuzzyPidSettings, StepResult
from musclewire.controllers.gains import Gains, load_gains
from musclewire.controllers.pid import PidController, PidSettings
from musclewire.controllers.plots import plot_rule_surfaces
from musclewire.controllers.references import (
    Reference,
    SampledReference,
    Staircase,
    Step,
    sampled_reference,
    staircase,
)
from musclewire.controllers.rules import RuleBase, load_rule_base, parse_rule_base, rule_base_names
from musclewire.controllers.steered_reference import SteeredReference

__all__ = [
    "CONTROLLERS",
    "Controller",
    "CompiledController",
    "ControllerFactory",
    "ControllerSetup",
    "FeedforwardController",
    "FeedforwardSettings",
    "Gains",
    "load_gains",
    "FuzzyPidController",
    "PidController",
    "PidSettings",
    "FuzzyPid",
    "FuzzyPidSettings",
    "ControllerState",
    "StepResult",
    "DriveLimits",
    "staircase",
    "Staircase",
    "Step",
    "sampled_reference",
    "SampledReference",
    "SteeredReference",
    "Reference",
    "rule_base_names",
    "load_rule_base",
    "parse_rule_base",
    "RuleBase",
    "infer_ratios",
    "infer_surface",
    "FuzzyRatios",
    "RatioSurface",
    "plot_rule_surfaces",
]
