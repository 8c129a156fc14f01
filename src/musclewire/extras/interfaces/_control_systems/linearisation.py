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

    Parameters
    ----------
    period_s
        Time between samples [s].
    kept
        Part of the state that is left after a sample.
    driven
        State per drive voltage after a sample [J/V].
    mean_kept
        Mean over a sample of what is left of the state.
    mean_driven
        Mean over a sample of the state per drive voltage [J/V].
    """

    period_s: float
    kept: float
    driven: float
    mean_kept: float
    mean_driven: float


@dataclass(frozen=True)
class LinearWire:
    """A wire near an operating point: d(heat)/dt = ``rate_per_s`` heat + ``power_w_per_v`` drive.

    Its state is the heat [J] beyond the operating point's enthalpy, its input the drive voltage [V] beyond the point's.

    Parameters
    ----------
    point
        The operating point.
    motion
        "branch": onward in the direction in which the point was reached; "minor loop": back, without a change of phase.
    rate_per_s
        The pole [1/s]; below 0 for a stable wire.
    power_w_per_v
        Slope of the power over the drive voltage [W/V].
    temperature_k_per_j
        Slope of temperature over heat [K/J].
    strain_per_j
        Slope of strain over heat [1/J].
    resistance_ohm_per_j
        Slope of resistance over heat [ohm/J].
    force_n_per_j
        Slope of the force of all legs over heat [N/J].
    """

    point: OperatingPoint
    motion: Motion
    rate_per_s: float
    power_w_per_v: float
    temperature_k_per_j: float
    strain_per_j: float
    resistance_ohm_per_j: float
    force_n_per_j: float

    @property
    def time_constant_s(self) -> float:
        """Time constant of the pole [s]; below 0 for a wire that runs away from the point."""
        return -1.0 / self.rate_per_s

    @property
    def displacement_m_per_j(self) -> float:
        """Slope of the connector's displacement over heat [m/J]."""
        return self.strain_per_j * self.point.wire.constants.leg_length_m

    def steady_per_volt(self, slope: float) -> float:
        """Return what a quantity changes by in the end, per volt of drive.

        Parameters
        ----------
        slope
            Slope of the quantity over heat, per joule.

        Returns
        -------
        The static gain, in the quantity's unit per volt.
        """
        return -slope * self.power_w_per_v / self.rate_per_s

    def estimate_per_j(self, model: SensingModel) -> float:
        """Return the slope of the estimated strain over heat: that of the model's mean curve at the point's resistance.

        Parameters
        ----------
        model
            A model that estimates strain.

        Returns
        -------
        The slope [1/J]; 0 outside of the model's valid range, where the estimate does not move.
        """
        curve = model.curve()
        per_ohm = 1.0 / (curve.resistance_max_ohm - curve.resistance_min_ohm)
        normalised = (self.point.resistance_ohm - curve.resistance_min_ohm) * per_ohm
        if not curve.normalised_min < normalised < curve.normalised_max:
            return 0.0
        slope = evaluate(derivative(curve.average_coefficients), normalised)
        return slope * per_ohm * self.resistance_ohm_per_j

    def sampled(self, period_s: float) -> SampledWire:
        """Return the wire between samples, exactly: its drive is held, and a reading is a mean over a sample.

        Parameters
        ----------
        period_s
            Time between samples [s], above 0.

        Returns
        -------
        The wire in discrete time.
        """
        exponent = self.rate_per_s * period_s
        growth = expm1(exponent)
        mean = growth / exponent if exponent else 1.0
        per_rate = self.power_w_per_v / self.rate_per_s
        return SampledWire(period_s, 1.0 + growth, per_rate * growth, mean, per_rate * (mean - 1.0))


def linearised(point: OperatingPoint, motion: Motion = "branch") -> LinearWire:
    """Return a wire linearised at an operating point.

    Parameters
    ----------
    point
        The operating point.
    motion
        "branch": onward in the direction in which the point was reached, with the transformation; "minor loop": back,
        with the wire's own heat capacity, the guide held by friction within its presliding.

    Returns
    -------
    The linear wire.

    Raises
    ------
    NumericsError
        If the wire finds no balance with its load next to the point.

    Notes
    -----
    d(heat)/dt = P(V, R) - loss(T), with P = V^2 R / (R + R_s)^2; R and T are functions of heat alone while the wire
    moves one way.
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
