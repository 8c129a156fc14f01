"""Rows of numbers of a wire in segments: what a segment remembers, where it lies, and the wire as a whole.

Heat, enthalpy and conductances of a segment are stated as if the whole wire were in its state: so all segments share
the constants of one wire, and a segment counts by its fraction of the length.
"""

from __future__ import annotations

from musclewire.arrays import FloatArray
from musclewire.wire import CLASS_SLOPES, CLASSES, Row, field

__all__ = ["SegmentPlace", "SegmentState", "SampleSetting", "WholeWire"]


class SegmentState(Row):
    """All that a segment remembers, and the trial of the step in progress."""

    temperature_k: float = field("K", "temperature")
    enthalpy_j: float = field("J", "enthalpy, 0 for austenite at 20 C")
    martensite_fraction: float = field("1", "volume fraction of martensite")
    r_phase_fraction: float = field("1", "volume fraction of R-phase")
    resistance_ohm: float = field("ohm", "resistance")
    contraction: float = field("1", "contraction relative to the cold wire")
    front_austenite: FloatArray = field("1", "front below which grains are austenite, by class of barrier", CLASSES)
    front_martensite: FloatArray = field("1", "front above which grains are martensite", CLASSES)
    front_trial: FloatArray = field("1, 1/K, 1/Pa", "fronts of the trial with their slopes", CLASS_SLOPES)
    net_w: float = field("W", "power less loss and conduction at the end of the last step")
    middle_w: float = field("W", "the same in the middle of the step in progress")
    last_heat_j: float = field("J", "heat of the last step")
    heat_j: float = field("J", "heat of the step in progress")
    carried_heat_j: float = field("J", "heat that the last step owes by the trapezoidal rule")
    temperature_slope_k_per_j: float = field("K/J", "rise of temperature over heat in the last step")
    resistance_slope_ohm_per_j: float = field("ohm/J", "rise of resistance over heat in the last step")
    trial_k: float = field("K", "temperature of the trial")
    trial_martensite: float = field("1", "martensite at the trial")
    trial_martensite_per_k: float = field("1/K", "its slope over temperature")
    trial_martensite_per_pa: float = field("1/Pa", "its slope over stress")
    trial_r_phase: float = field("1", "R-phase at the trial")
    trial_r_phase_per_k: float = field("1/K", "its slope over temperature")
    trial_r_phase_per_pa: float = field("1/Pa", "its slope over stress")
    trial_contraction: float = field("1", "contraction at the trial")
    contraction_per_k: float = field("1/K", "its slope over temperature")
    contraction_per_pa: float = field("1/Pa", "its slope over stress")
    missing_j: float = field("J", "enthalpy at the trial less the enthalpy there is")
    missing_per_k: float = field("J/K", "its slope over temperature")
    missing_per_pa: float = field("J/Pa", "its slope over stress")


class SegmentPlace(Row):
    """Where a segment lies, and how it differs from the others."""

    weight: float = field("1", "fraction of the wire's length")
    temperature_shift_k: float = field("K", "transformation temperatures beyond those of the wire")
    convection_factor: float = field("1", "loss to the air as a multiple of that of the wire in still air")
    before_w_per_k: float = field("W/K", "conductance to the segment before, or to the clamp")
    after_w_per_k: float = field("W/K", "conductance to the segment after, or to the clamp")


class SampleSetting(Row):
    """Circuit, air, load and age of the wire during a sample."""

    drive_voltage_v: float = field("V", "drive voltage")
    outside_ohm: float = field("ohm", "shunt, and leads outside the measured voltage")
    inside_ohm: float = field("ohm", "leads and contacts within the measured voltage of the wire")
    ambient_k: float = field("K", "temperature of the air and of the clamps")
    resistance_factor: float = field("1", "resistance as a multiple of that of the model")
    temperature_shift_k: float = field("K", "transformation temperatures beyond those of the wire")
    residual_strain: float = field("1", "strain that the wire has gained by use")
    zero_contraction: float = field("1", "contraction of the wire at rest, the zero of its connector")
    force_n: float = field("N", "force of the load at the connector's zero")
    spring_n: float = field("N", "force of the spring per contraction")
    duration_s: float = field("s", "length of the sample")
    steps: float = field("1", "number of steps")


class WholeWire(Row):
    """What the segments have in common, and sums since the start."""

    time_s: float = field("s", "time since the wire was first at rest")
    stress_pa: float = field("Pa", "stress of one leg, the same in all segments")
    contraction: float = field("1", "contraction of the wire")
    connector_contraction: float = field("1", "displacement of the connector over the leg's length")
    friction_n: float = field("N", "friction of the guide, positive against contraction")
    resistance_ohm: float = field("ohm", "resistance")
    current_a: float = field("A", "current")
    heat_in_j: float = field("J", "electrical heat since the start")
    heat_to_air_j: float = field("J", "heat lost to the air since the start")
    heat_to_clamps_j: float = field("J", "heat lost to the clamps since the start")
    power_w: float = field("W", "electrical power")
    air_w: float = field("W", "loss to the air")
    clamps_w: float = field("W", "loss to the clamps")
    cycles: float = field("1", "full transformation cycles since the start")
    stress_slope_pa_per_j: float = field("Pa/J", "rise of stress over the mean heat of the last step")
    last_heat_j: float = field("J", "mean heat of the last step")
    hottest_k: float = field("K", "highest temperature of any segment since the start")
    step_error_k: float = field("K", "largest estimated error of a step in temperature since the start")
    evaluations: float = field("1", "evaluations of all segments since the start")
    unsolved_steps: float = field("1", "steps since the start whose balances were not met")
