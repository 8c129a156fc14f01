"""Gains of a controller from a slow loop: the plant that the recording shows, and a published rule for its PI.

The plant on a branch is of first order, K = dS/dw and tau_e = tau + lambda K (as the wire's model has it), with a dead
time theta. By SIMC (Skogestad 2003) with tau_c = theta, "tight but robust":

    K_c = tau_e / (K (tau_c + theta)),   T_i = min(tau_e, 4 (tau_c + theta))

so nothing in a gain is fitted to a rig. The stated margins are those of the worst level of either branch.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from markupsafe import Markup

from musclewire.arrays import FloatArray
from musclewire.controllers import (
    CONTROLLERS,
    DEFAULT_RULE_BASE,
    FeedforwardSettings,
    FuzzyPidSettings,
    Gains,
    load_rule_base,
    save_gains,
    with_error_unit,
)
from musclewire.errors import CallerError, RecordingError, nearest_hint
from musclewire.identify._speed_limits.plant import LEVELS, steady_levels
from musclewire.identify._use_of_model import DEAD_SAMPLES, alloy_of, error_unit_for, require_ohms
from musclewire.sensing import SHOWN_AS, SensingModel, wire_model_of
from musclewire.signals import Recording, RunFacts
from musclewire.wire import HeatBalance

if TYPE_CHECKING:
    from matplotlib.axes import Axes

TUNED = ("inverse-model", "fuzzy-pid")
MIDDLE_KP = 0.06
FREQUENCIES_RAD_PER_S = np.geomspace(1e-2, 1e3, 4000)


class StabilityMargins(NamedTuple):
    """Stability margins of the feedback at the worst level of both branches."""

    gain: float  # factor by which the gain may rise
    phase_rad: float  # may be lost at the crossover
    delay_s: float  # further dead time that the loop bears


@dataclass(frozen=True)
class Tuning:
    """The gains of a wire, found from its slow loop by a rule."""

    controller: str  # name of the controller: "inverse-model" or "fuzzy-pid"
    settings: FeedforwardSettings | FuzzyPidSettings  # its settings, for ``control(..., controller=..., settings=...)``
    plant: FeedforwardSettings  # the identified plant: branches, time constants and heat, with the gains of SIMC
    margins: StabilityMargins  # gain margin, phase margin [rad] and delay margin [s] of the PI that SIMC gives

    @property
    def gains(self) -> Gains:
        """Controller and settings alone."""
        return Gains(self.controller, self.settings)

    def kept_in(self, model: SensingModel) -> SensingModel:
        """Return a model with these gains: those that a loop with it takes by default."""
        return replace(model, gains=self.gains.table(), no_gains="")

    def save(self, path: str | Path) -> None:
        """Write a gains file (TOML) in place of one that exists. Raises CallerError if it cannot be written there."""
        save_gains(self.gains, path, tuple(str(self).splitlines()))

    def plot(self, axes: Axes | None = None, *, style: str = "screen") -> Axes:
        """Draw the steady power of both branches, and the margins in the title; style as in ``Recording.plot``."""
        from musclewire.figures import axes_to_draw_on
        from musclewire.pages import COOLING, HEATING

        plant = self.plant
        factor, unit = SHOWN_AS[plant.quantity]
        with axes_to_draw_on(axes, style) as here:
            here.plot(plant.heating_power_w, factor * plant.levels, color=HEATING, label="heating")
            here.plot(plant.cooling_power_w, factor * plant.levels, color=COOLING, label="cooling")
            here.set(xlabel="steady electrical power [W]", ylabel=f"{plant.quantity} [{unit}]")
            here.set_title(str(self).splitlines()[-1], fontsize="small", wrap=True)
            here.legend()
            return here

    def report(self) -> dict[str, Any]:
        """Return the numbers of ``musclewire tune --json``."""
        gains = feedback_gains(self.plant)
        return {
            "controller": self.controller,
            "rule": "SIMC",
            "thermal_time_constant_s": self.plant.thermal_time_constant_s,
            "dead_time_s": self.plant.dead_time_s,
            "closed_loop_time_s": self.plant.closed_loop_time_s,
            "integral_time_s": self.plant.integral_time_s,
            "smallest_gain_w_per_unit": float(min(row.min() for row in gains)),
            "largest_gain_w_per_unit": float(max(row.max() for row in gains)),
            "gain_margin": self.margins.gain,
            "phase_margin_deg": math.degrees(self.margins.phase_rad),
            "delay_margin_s": self.margins.delay_s,
        }

    def _repr_html_(self) -> str:
        """Return plant, gains and margins for a notebook, as ``print`` shows them."""
        return Markup("<pre>{}</pre>").format(str(self))

    def __str__(self) -> str:
        """Return plant, gains and margins in a few lines."""
        plant, gains = self.plant, feedback_gains(self.plant)
        factor, unit = SHOWN_AS[plant.quantity]
        low, high = (float(f(f(row) for row in gains)) / factor for f in (min, max))
        return "\n".join(
            [
                f"controller {self.controller}, PI by SIMC (Skogestad 2003) on the plant of the slow loop",
                f"steady power {plant.cooling_power_w[0]:.3g} to {plant.heating_power_w[-1]:.3g} W, time constant "
                f"{plant.thermal_time_constant_s:.3g} s in air, "
                f"{plant.heat_per_unit / factor:.3g} J/{unit} to transform",
                f"tau_c {plant.closed_loop_time_s:.3g} s, dead time {plant.dead_time_s:.3g} s: K_c {low:.3g} to "
                f"{high:.3g} W/{unit}, T_i {plant.integral_time_s:.3g} s",
                f"margins at the worst level: gain {self.margins.gain:.2f}, phase "
                f"{math.degrees(self.margins.phase_rad):.0f} deg, delay {1e3 * self.margins.delay_s:.0f} ms",
            ]
        )


def tune(
    model: SensingModel,
    recording: Recording,
    *,
    controller: str = "inverse-model",
    closed_loop_time_s: float | None = None,
    rule_base: str | None = None,
) -> Tuning:
    """Find the gains of a controller from what the slow loop that characterized a wire shows of it.

    Parameters
    ----------
    model
        The model of the wire, with its steady power on both branches; quantity and range are the controller's.
    recording
        The slow loop that it was fitted to (``characterize``): its metadata state sample period and shunt, and the
        wire's heat capacity and heat loss, as every rig states them.
    controller
        "inverse-model", or "fuzzy-pid" whose one scale is then found from the plant.
    closed_loop_time_s
        tau_c [s]; the dead time if None, as SIMC recommends. A longer one is slower, with larger margins.
    rule_base
        Rule base of the fuzzy PID; its default if None.

    Returns
    -------
    Controller, settings, the identified plant, and margins.

    Raises
    ------
    CallerError
        For a controller that has no rule here, a rule base without the fuzzy PID, a time that is not above 0, or a
        model without the power through its loop.
    RecordingError
        If the recording does not state the heat balance of its wire.

    References
    ----------
    Skogestad 2003, Simple analytic rules for model reduction and PID controller tuning,
    doi 10.1016/S0959-1524(02)00062-8.

    Examples
    --------
    >>> import musclewire as mw
    >>> with mw.open_rig("simulated") as rig:
    ...     slow = mw.characterize(rig)
    >>> mw.tune(mw.fit(slow), slow).controller
    'inverse-model'
    """
    CONTROLLERS.find(controller)
    if controller not in TUNED:
        raise CallerError(f"there is no tuning rule for '{controller}'{nearest_hint(controller, TUNED)}")
    if rule_base is not None and controller != "fuzzy-pid":
        raise CallerError(
            f"a rule base belongs to the controller fuzzy-pid, not to {controller}: leave one of them out"
        )
    if closed_loop_time_s is not None and not closed_loop_time_s > 0.0:
        raise CallerError(f"closed_loop_time_s is {closed_loop_time_s:g}: give a time above 0 s")
    require_ohms(model)
    plant = identified_plant(model, recording.facts, closed_loop_time_s)
    settings = plant if controller == "inverse-model" else fuzzy_settings(model, plant, rule_base)
    return Tuning(controller, settings, plant, worst_margins(plant))


def with_gains(model: SensingModel, facts: RunFacts) -> SensingModel:
    """Return a model with the gains of its wire, as ``tune`` finds them, or with why there are none."""
    try:
        plant = identified_plant(model, facts)
    except (RecordingError, CallerError) as error:
        return replace(model, no_gains=str(error))
    return replace(model, gains=Gains("inverse-model", plant).table())


def settings_for(model: SensingModel, settings: FuzzyPidSettings | None = None) -> FuzzyPidSettings:
    """Return the fuzzy PID's settings with the error unit fitted to the model's quantity, unless they name one."""
    return with_error_unit(settings or FuzzyPidSettings(), error_unit_for(model))


def fuzzy_settings(model: SensingModel, plant: FeedforwardSettings, rule_base: str | None) -> FuzzyPidSettings:
    """Return the fuzzy PID's settings for a plant: the paper's ranges, a scale, and a rule base that is known."""
    rules = DEFAULT_RULE_BASE if rule_base is None else rule_base
    load_rule_base(rules)
    return FuzzyPidSettings(input_scale=fuzzy_scale(model, plant), error_unit=error_unit_for(model), rule_base=rules)


def stated_heat_balance(model: SensingModel, facts: RunFacts) -> tuple[float, float] | None:
    """Return time constant [s] and heat [J] of the whole transformation as a rig states them; None if it does not."""
    try:
        stated = HeatBalance.stated_in(facts)
    except RecordingError:
        return None
    alloy = alloy_of(model)
    heat_j = stated.capacity_j_per_k * alloy.latent_heat_j_per_kg.value / alloy.specific_heat_j_per_kg_k.value
    return stated.lag_s, heat_j


def identified_plant(
    model: SensingModel, facts: RunFacts, closed_loop_time_s: float | None = None
) -> FeedforwardSettings:
    """Return the plant that the model of a wire states, for a rig that heats it, with the gains of SIMC.

    Raises CallerError for a model without that of its wire, RecordingError for a rig without its heat balance,
    and for a loop whose power does not rise.
    """
    try:
        highest_k = facts.number("limit_maximum_temperature_k", "highest temperature of the wire")
        maximum_w = HeatBalance.stated_in(facts).power_w(highest_k)
    except RecordingError:
        raise RecordingError(
            f"{facts.whose} does not state which rig heats the wire and how warm it may become, by which gains are "
            "found: record the slow loop on that rig with 'musclewire characterize'"
        ) from None
    wire = wire_model_of(model)
    levels = np.linspace(model.quantity_min, model.quantity_max, LEVELS)
    steady = steady_levels(model, levels)
    tau_s, heat = wire.time_constant_s.value, wire.heat_j_per_unit.value
    span = model.quantity_max - model.quantity_min
    dead_s = DEAD_SAMPLES * facts.sample_period_s
    response_s = dead_s + (dead_s if closed_loop_time_s is None else closed_loop_time_s)
    slopes_w = [float(np.median(np.diff(row))) * (LEVELS - 1) / span for row in (steady.heating_w, steady.cooling_w)]
    if not min(slopes_w) > 0.0:
        raise RecordingError(
            f"the power that holds the {model.quantity} does not rise with it: record the slow loop more slowly, from "
            "cold to the largest drive and back"
        )
    slowest_s = tau_s + heat / min(slopes_w)
    return FeedforwardSettings(
        quantity=model.quantity,
        lowest=model.quantity_min,
        highest=model.quantity_max,
        heating_power_w=tuple(steady.heating_w.tolist()),
        cooling_power_w=tuple(steady.cooling_w.tolist()),
        resistance_ohm=tuple(steady.resistance_ohm.tolist()),
        shunt_resistance_ohm=facts.shunt_resistance_ohm,
        thermal_time_constant_s=tau_s,
        heat_per_unit=heat,
        closed_loop_time_s=response_s - dead_s,
        dead_time_s=dead_s,
        integral_time_s=min(slowest_s, 4.0 * response_s),
        maximum_steady_power_w=maximum_w,
    )


def feedback_gains(plant: FeedforwardSettings) -> tuple[FloatArray, FloatArray]:
    """Return K_c [W per unit] at each level of heating and cooling branch."""
    response_s = plant.closed_loop_time_s + plant.dead_time_s
    tau_s, heat = plant.thermal_time_constant_s, plant.heat_per_unit
    heating, cooling = ((tau_s * slope + heat) / response_s for slope in plant.branch_slopes())
    return heating, cooling


def worst_margins(plant: FeedforwardSettings) -> StabilityMargins:
    """Return the smallest margins over all levels and both branches."""
    all_levels = [
        margins_of(gain, float(slope), plant)
        for gains, slopes in zip(feedback_gains(plant), plant.branch_slopes(), strict=True)
        for gain, slope in zip(gains.tolist(), slopes, strict=True)
    ]
    return StabilityMargins(*(min(row) for row in zip(*all_levels, strict=True)))


def margins_of(gain: float, slope: float, plant: FeedforwardSettings) -> StabilityMargins:
    """Return the margins of the PI on the plant at one level."""
    s = 1j * FREQUENCIES_RAD_PER_S
    lag = slope + s * (slope * plant.thermal_time_constant_s + plant.heat_per_unit)
    loop = gain * (1.0 + 1.0 / (plant.integral_time_s * s)) / lag
    size = np.abs(loop)
    phase = np.unwrap(np.angle(loop)) - plant.dead_time_s * FREQUENCIES_RAD_PER_S
    crossover = int(np.argmax(size < 1.0))
    turned = int(np.argmax(phase < -math.pi))
    left_rad = math.pi + float(phase[crossover])
    return StabilityMargins(1.0 / float(size[turned]), left_rad, left_rad / float(FREQUENCIES_RAD_PER_S[crossover]))


def fuzzy_scale(model: SensingModel, plant: FeedforwardSettings) -> float:
    """Return the volts per error unit at which the paper's middle K_p is SIMC's K_c, the smaller of both branches."""
    middle = len(plant.resistance_ohm) // 2
    resistance = plant.resistance_ohm[middle]
    total = resistance + plant.shunt_resistance_ohm
    power = plant.heating_power_w[middle]
    volts_per_watt = total / (2.0 * math.sqrt(power * resistance))
    gain_w = float(min(row.min() for row in feedback_gains(plant)))
    return gain_w * error_unit_for(model) * volts_per_watt / MIDDLE_KP
