"""A wire linearised at an operating point: one pole, and the slopes of everything that is measured.

A linearisation of a wire with hysteresis belongs to a direction. Onward, the transformation continues as on the way to
the operating point: the fronts move with temperature, and latent heat adds to the heat capacity. Back, no grain changes
its phase until the barrier is passed: the wire has its own heat capacity alone, as in every small loop about the point.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import expm1
from typing import Literal

from musclewire.extras.interfaces._control_systems.heating import heat_flow_of, heated_to
from musclewire.extras.interfaces._control_systems.operating_points import OperatingPoint
from musclewire.sensing import SensingModel, derivative, evaluate

Motion = Literal["branch", "minor loop"]
# The slopes of the phases belong to a direction: they are taken this far from the operating point, as a rise of the
# wire's own heat capacity [K].
ASIDE_K = 1e-3


@dataclass(frozen=True)
class SampledWire:
    """A linear wire between samples, its drive held and its readings means over a sample.

    The state after a sample is ``kept`` times the state before it plus ``driven`` times the drive; the mean of the
    state over the sample is ``mean_kept`` times the state before plus ``mean_driven`` times the drive.
    """

    period_s: float
    kept: float
    driven: float  # [J/V]
    mean_kept: float
    mean_driven: float  # [J/V]


@dataclass(frozen=True)
class LinearWire:
    """A wire near an operating point: d(heat)/dt = ``rate_per_s`` heat + ``power_w_per_v`` drive.

    Its state is the heat [J] beyond the operating point's enthalpy, its input the drive voltage [V] beyond the point's.
    """

    point: OperatingPoint
    motion: Motion  # "branch": onward as the point was reached; "minor loop": back, without a change of phase
    rate_per_s: float  # the pole; below 0 for a stable wire
    power_w_per_v: float
    temperature_k_per_j: float  # this and those that follow are slopes over heat
    strain_per_j: float
    resistance_ohm_per_j: float
    force_n_per_j: float  # of all legs

    @property
    def time_constant_s(self) -> float:
        """Time constant of the pole [s]; below 0 for a wire that runs away from the point."""
        return -1.0 / self.rate_per_s

    @property
    def displacement_m_per_j(self) -> float:
        """Slope of the connector's displacement over heat [m/J]."""
        return self.strain_per_j * self.point.wire.constants.leg_length_m

    def steady_per_volt(self, slope: float) -> float:
        """Return what a quantity changes by in the end, per volt of drive, from its slope over heat per joule."""
        return -slope * self.power_w_per_v / self.rate_per_s

    def estimate_per_j(self, model: SensingModel) -> float:
        """Return the slope over heat of the strain by a model's mean curve; 0 outside of its valid range."""
        curve = model.curve()
        per_ohm = 1.0 / (curve.resistance_max_ohm - curve.resistance_min_ohm)
        normalised = (self.point.resistance_ohm - curve.resistance_min_ohm) * per_ohm
        if not curve.normalised_min < normalised < curve.normalised_max:
            return 0.0
        slope = evaluate(derivative(curve.average_coefficients), normalised)
        return slope * per_ohm * self.resistance_ohm_per_j

    def sampled(self, period_s: float) -> SampledWire:
        """Return the wire between samples, exactly: its drive is held, and a reading is a mean over a sample."""
        exponent = self.rate_per_s * period_s
        growth = expm1(exponent)
        mean = growth / exponent if exponent else 1.0
        per_rate = self.power_w_per_v / self.rate_per_s
        return SampledWire(period_s, 1.0 + growth, per_rate * growth, mean, per_rate * (mean - 1.0))


def linearised(point: OperatingPoint, motion: Motion = "branch") -> LinearWire:
    """Return a wire linearised at a point; NumericsError if it finds no balance with its load next to the point.

    d(heat)/dt = P(V, R) - loss(T), with P = V^2 R / (R + R_s)^2; R and T are functions of heat alone while the wire
    moves one way. In a "minor loop" the guide is held by friction within its presliding.
    """
    constants, state = point.wire.constants, point.state
    onward = 1.0 if (point.branch == "heating") == (motion == "branch") else -1.0
    aside_j = onward * ASIDE_K * constants.heat_capacity_j_per_k
    near = heated_to(state, constants, state.enthalpy_j + aside_j)
    flow = heat_flow_of(state, constants, point.drive_voltage_v)
    per_j = near.resistance_slope_ohm_per_j
    return LinearWire(
        point=point,
        motion=motion,
        rate_per_s=flow.per_ohm * per_j - flow.loss_per_k * near.temperature_slope_k_per_j,
        power_w_per_v=flow.per_volt,
        temperature_k_per_j=near.temperature_slope_k_per_j,
        strain_per_j=near.contraction_slope_per_j,
        resistance_ohm_per_j=per_j,
        force_n_per_j=near.stress_slope_pa_per_j * constants.legs * constants.area_m2,
    )
