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
from numpy.typing import NDArray

from musclewire.arrays import FloatArray
from musclewire.controllers import (
    CONTROLLERS,
    DEFAULT_RULE_BASE,
    FeedforwardSettings,
    FuzzyPidSettings,
    Gains,
    load_rule_base,
    save_gains,
)
from musclewire.errors import CallerError, RecordingError, nearest_hint
from musclewire.identify._recordings import reference_quantity, resistance_reading
from musclewire.identify._use_of_model import error_unit_for, require_ohms
from musclewire.parameters import Alloy, load_alloy, load_wire, names
from musclewire.sensing import SHOWN_AS, SensingModel, evaluate, smooth, smooth_slope
from musclewire.signals import Recording, RunFacts

if TYPE_CHECKING:
    from matplotlib.axes import Axes

LEVELS = 33
# Samples within this many spacings of a level determine it, by a straight line through them; where they are sparse, the
# nearest few do, up to so many spacings away.
NEAR_SPACINGS, FEWEST_SAMPLES, FAR_SPACINGS = 0.8, 4, 3.0
# The derivatives of a slow loop are taken over a second of it.
SMOOTHING_S = 1.0
# From a command to its effect on the estimate: one sample until it is measured, half a sample of the hold, and half a
# sample of the estimator's filter.
DEAD_SAMPLES = 2.0
TUNED = ("inverse-model", "fuzzy-pid")
MIDDLE_KP = 0.06
FREQUENCIES_RAD_PER_S = np.geomspace(1e-2, 1e3, 4000)


class StabilityMargins(NamedTuple):
    """Stability margins of the feedback at the worst level of both branches.

    Parameters
    ----------
    gain
        Factor by which the gain may rise.
    phase_rad
        Phase that may be lost at the crossover [rad].
    delay_s
        Further dead time [s] that the loop bears.
    """

    gain: float
    phase_rad: float
    delay_s: float


@dataclass(frozen=True)
class Tuning:
    """The gains of a wire, found from its slow loop by a rule.

    Parameters
    ----------
    controller
        Name of the controller: "inverse-model" or "fuzzy-pid".
    settings
        Its settings, for ``control(..., controller=..., settings=...)``.
    plant
        The identified plant: branches, time constants and heat, with the gains of SIMC.
    margins
        Gain margin, phase margin [rad] and delay margin [s] of the PI that SIMC gives.
    self_sensed
        True if the recording has no instrument for the model's quantity, which the model then reads from resistance.
    """

    controller: str
    settings: FeedforwardSettings | FuzzyPidSettings
    plant: FeedforwardSettings
    margins: StabilityMargins
    self_sensed: bool = False

    @property
    def gains(self) -> Gains:
        """Controller and settings alone."""
        return Gains(self.controller, self.settings)

    def kept_in(self, model: SensingModel) -> SensingModel:
        """Return a model with these gains: those that a loop with it takes by default.

        Parameters
        ----------
        model
            The model that they were found for.

        Returns
        -------
        The model, otherwise as it was.
        """
        return replace(model, gains=self.gains.table(), no_gains="")

    def save(self, path: str | Path) -> None:
        """Write a gains file (TOML).

        Parameters
        ----------
        path
            File to write; one that exists is replaced.

        Raises
        ------
        CallerError
            If the file cannot be written there.
        """
        save_gains(self.gains, path, tuple(str(self).splitlines()))

    def plot(self, axes: Axes | None = None, *, style: str = "screen") -> Axes:
        """Draw the steady power of both branches, and the margins of the feedback in the title.

        Parameters
        ----------
        axes
            Axes to draw on; those of a new figure by default.
        style
            Size and fonts of the new figure, as in ``Recording.plot``; axes that are given keep their own.

        Returns
        -------
        The axes; ``found.plot().figure.savefig("gains.pdf")`` writes their figure.

        Raises
        ------
        CallerError
            For an unknown style; the message suggests the nearest.
        """
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
            "self_sensed": self.self_sensed,
        }

    def _repr_html_(self) -> str:
        """Return plant, gains and margins for a notebook, as ``print`` shows them."""
        return Markup("<pre>{}</pre>").format(str(self))

    def __str__(self) -> str:
        """Return plant, gains and margins in a few lines."""
        plant, gains = self.plant, feedback_gains(self.plant)
        factor, unit = SHOWN_AS[plant.quantity]
        low, high = (float(f(f(row) for row in gains)) / factor for f in (min, max))
        by = f", {plant.quantity} by the model's own branches" if self.self_sensed else ""
        return "\n".join(
            [
                f"controller {self.controller}, PI by SIMC (Skogestad 2003) on the plant of the slow loop{by}",
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
    """Find the gains of a controller from the slow loop that characterized a wire.

    Parameters
    ----------
    model
        The model fitted to the recording: its quantity and its range are the controller's.
    recording
        The slow loop (``characterize``), with the wire's heat capacity and heat loss in its metadata, which every rig
        states. Without a reference instrument the model reads its quantity from the resistance, between B and C on each
        branch.
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
        For a controller that has no rule here, a rule base without the fuzzy PID, or a time that is not above 0.
    RecordingError
        If the recording lacks the heat balance of its wire, a voltage, or a loop.

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
    plant = identified_plant(model, recording, closed_loop_time_s)
    settings = plant if controller == "inverse-model" else fuzzy_settings(model, plant, rule_base)
    self_sensed = reference_quantity(recording, model.quantity) is None
    return Tuning(controller, settings, plant, worst_margins(plant), self_sensed)


def with_gains(model: SensingModel, recording: Recording) -> SensingModel:
    """Return a model with the gains of its slow loop, as ``tune`` finds them, or with why there are none."""
    try:
        plant = identified_plant(model, recording, None)
    except (RecordingError, CallerError) as error:
        return replace(model, no_gains=str(error))
    return replace(model, gains=Gains("inverse-model", plant).table())


def gains_of(model: SensingModel, sample_period_s: float) -> Gains | None:
    """Return the gains that a model keeps, for a loop of a sample period.

    Parameters
    ----------
    model
        The model, as ``fit`` returns it.
    sample_period_s
        Time [s] between two samples of the loop; longer than in the slow loop, it makes the loop slower.

    Returns
    -------
    Controller and settings; None for a model without gains.

    Raises
    ------
    CallerError
        If what the model keeps are no gains.
    """
    if not model.gains:
        return None
    gains = Gains.read(model.gains, "the gains kept in this model")
    if isinstance(gains.settings, FeedforwardSettings):
        return Gains(gains.controller, at_period(gains.settings, sample_period_s))
    return gains


def fuzzy_settings(model: SensingModel, plant: FeedforwardSettings, rule_base: str | None) -> FuzzyPidSettings:
    """Return the fuzzy PID's settings for a plant: the paper's ranges, a scale, and a rule base that is known."""
    rules = DEFAULT_RULE_BASE if rule_base is None else rule_base
    load_rule_base(rules)
    return FuzzyPidSettings(input_scale=fuzzy_scale(model, plant), error_unit=error_unit_for(model), rule_base=rules)


class HeatBalance(NamedTuple):
    """Heat balance of a wire in still air: capacity [J/K], loss [W/K], and its warmest [K above the air]."""

    capacity_j_per_k: float
    loss_w_per_k: float
    warmest_k: float


def heat_balance(facts: RunFacts) -> HeatBalance:
    """Return the heat balance that a rig states. Raises RecordingError if it does not."""
    keys = ("heat_capacity_j_per_k", "heat_loss_w_per_k", "maximum_temperature_k", "ambient_temperature_k")
    stated = [facts.number_or_none(f"limit_{key}") for key in keys]
    known = [number for number in stated if number is not None and number > 0.0]
    if len(known) != len(keys):
        raise RecordingError(
            f"{facts.whose} does not state which rig heats the wire and how warm it may become, by which gains are "
            "found: record the slow loop on that rig with 'musclewire characterize'"
        )
    capacity, loss, highest_k, air_k = known
    return HeatBalance(capacity, loss, highest_k - air_k)


def alloy_of(model: SensingModel) -> Alloy:
    """Return the alloy of a model's wire, Flexinol's for a wire that is not known by name."""
    name = str(model.wire.get("wire", ""))
    return load_alloy(load_wire(name).alloy if name in names("wire") else "flexinol")


def heat_of_transformation_j(model: SensingModel, balance: HeatBalance) -> float:
    """Return the heat [J] of the whole transformation: the alloy's latent over specific heat, times the capacity."""
    alloy = alloy_of(model)
    return balance.capacity_j_per_k * alloy.latent_heat_j_per_kg.value / alloy.specific_heat_j_per_kg_k.value


def identified_plant(
    model: SensingModel, recording: Recording, closed_loop_time_s: float | None
) -> FeedforwardSettings:
    """Return the plant of a slow loop with the gains of SIMC."""
    balance, facts = heat_balance(recording.facts), recording.facts
    tau_s = balance.capacity_j_per_k / balance.loss_w_per_k
    span = model.quantity_max - model.quantity_min
    heat = heat_of_transformation_j(model, balance) / model.quantity_max
    loop = steady_loop(model, recording, tau_s, heat)
    dead_s = DEAD_SAMPLES * facts.sample_period_s
    response_s = dead_s + (dead_s if closed_loop_time_s is None else closed_loop_time_s)
    slopes_w = [float(np.median(np.diff(row))) * (LEVELS - 1) / span for row in (loop.heating_w, loop.cooling_w)]
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
        heating_power_w=tuple(loop.heating_w.tolist()),
        cooling_power_w=tuple(loop.cooling_w.tolist()),
        resistance_ohm=tuple(loop.resistance_ohm.tolist()),
        shunt_resistance_ohm=facts.shunt_resistance_ohm,
        thermal_time_constant_s=tau_s,
        heat_per_unit=heat,
        closed_loop_time_s=response_s - dead_s,
        dead_time_s=dead_s,
        integral_time_s=min(slowest_s, 4.0 * response_s),
        maximum_steady_power_w=balance.loss_w_per_k * balance.warmest_k,
    )


def at_period(plant: FeedforwardSettings, sample_period_s: float) -> FeedforwardSettings:
    """Return a plant whose samples are further apart than those that it was found from: a later, slower loop.

    Parameters
    ----------
    plant
        The plant, as ``tune`` finds it, with the dead time of the recording's samples.
    sample_period_s
        Time [s] between two samples of the loop.

    Returns
    -------
    The plant with the dead time of these samples and, by SIMC, tau_c no shorter than it; unchanged for faster ones.
    """
    dead_s = DEAD_SAMPLES * sample_period_s
    if dead_s <= plant.dead_time_s:
        return plant
    response_s = dead_s + max(dead_s, plant.closed_loop_time_s)
    slower = {
        "dead_time_s": dead_s,
        "closed_loop_time_s": response_s - dead_s,
        "integral_time_s": plant.integral_time_s * response_s / (plant.closed_loop_time_s + plant.dead_time_s),
    }
    return plant.model_copy(update=slower)


class SteadyLoop(NamedTuple):
    """Power [W] that holds each level on both branches, and the wire's resistance [ohm] there."""

    heating_w: FloatArray
    cooling_w: FloatArray
    resistance_ohm: FloatArray


def steady_loop(model: SensingModel, recording: Recording, tau_s: float, heat_per_unit: float) -> SteadyLoop:
    """Return the steady loop: that of the last cycle, without what its slow changes take and give."""
    reading, rows = resistance_reading(recording), last_cycle(recording)
    resistance = np.where(reading.valid, reading.resistance_ohm, np.nan)
    measured = reference_quantity(recording, model.quantity)
    quantity, usable = quantity_by_branches(model, resistance, rows) if measured is None else (measured, True)
    power = recording["shunt_voltage_v"] / recording.facts.shunt_resistance_ohm * recording["wire_voltage_v"]
    smooth, power_rate = smoothed(power, recording.facts.sample_period_s)
    moved, rate = smoothed(quantity, recording.facts.sample_period_s)
    steady = smooth - tau_s * power_rate - heat_per_unit * rate
    moved = np.where(usable, moved, np.nan)
    top = rows.start + int(np.argmax(smooth[rows]))
    levels = np.linspace(model.quantity_min, model.quantity_max, LEVELS)
    halves = [slice(rows.start, top), slice(top, rows.stop)]
    powers = [np.maximum.accumulate(by_level(moved[half], steady[half], levels)) for half in halves]
    ohms = [by_level(moved[half], resistance[half], levels) for half in halves]
    heating = np.maximum(powers[0], 1e-6)
    return SteadyLoop(heating, np.clip(powers[1], 1e-6, heating), np.asarray(0.5 * (ohms[0] + ohms[1])))


def quantity_by_branches(
    model: SensingModel, resistance_ohm: FloatArray, rows: slice
) -> tuple[FloatArray, NDArray[np.bool_]]:
    """Return the model's quantity in a cycle from cold to hot and back, and where it holds: between B and C."""
    low, high = model.valid_resistance_ohm
    row = np.arange(len(resistance_ohm))
    at_c = rows.start + int(np.argmin(np.nan_to_num(resistance_ohm[rows], nan=np.inf)))
    in_cycle = (row >= rows.start) & (row < rows.stop)
    # Cold of B the resistance falls again: what is before the last row above the model's range, and after the first.
    cold = row[in_cycle & (resistance_ohm > high)]
    first = max(cold[cold < at_c], default=rows.start)
    last = min(cold[cold > at_c], default=rows.stop)
    known = np.clip(np.nan_to_num(resistance_ohm, nan=low), low, high)
    fraction = (known - model.resistance_min_ohm) / (model.resistance_max_ohm - model.resistance_min_ohm)
    by_branch = (evaluate(one, fraction) for one in (model.heating_coefficients, model.cooling_coefficients))
    return np.where(row < at_c, *by_branch), (row > first) & (row < last) & (known == resistance_ohm)


def smoothed(values: FloatArray, period_s: float) -> tuple[FloatArray, FloatArray]:
    """Return values and their rate [1/s], smoothed over a second. Raises RecordingError for few samples."""
    window = max(2 * round(0.5 * SMOOTHING_S / period_s) + 1, 5)
    if len(values) < 4 * window:
        raise RecordingError(
            f"the recording has {len(values)} samples: a slow loop is needed, from cold to hot and back"
        )
    return smooth(values, window), smooth_slope(values, window) / period_s


def last_cycle(recording: Recording) -> slice:
    """Return the rows of the last cycle; all of them in a recording without cycles."""
    if "cycle" not in recording:
        return slice(0, len(recording))
    rows = np.flatnonzero(recording["cycle"] == recording["cycle"].max())
    return slice(int(rows[0]), int(rows[-1]) + 1)


def by_level(quantity: FloatArray, values: FloatArray, levels: FloatArray) -> FloatArray:
    """Return values at levels of the quantity, by a line through the samples near each. Raises RecordingError."""
    spacing = levels[1] - levels[0]
    found = np.full(len(levels), np.nan)
    for index, level in enumerate(levels):
        away = np.where(np.isfinite(values), np.abs(quantity - level), np.inf)
        fewest_away = float(np.sort(away)[:FEWEST_SAMPLES][-1]) if away.size >= FEWEST_SAMPLES else math.inf
        rows = away <= max(NEAR_SPACINGS * spacing, fewest_away)
        if fewest_away < FAR_SPACINGS * spacing:
            found[index] = np.polyfit(quantity[rows] - level, values[rows], 1)[1]
    known = np.isfinite(found)
    if known.sum() < len(levels) // 2:
        raise RecordingError(
            "the recording does not pass through the model's range on both branches: tune on the slow loop that the "
            "model was fitted to"
        )
    return np.asarray(np.interp(levels, levels[known], found[known]))


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
    """Return the fuzzy PID's volts per error unit at which the middle of its K_p is the K_c of SIMC.

    Its range of K_p and K_I stays the paper's. The smallest K_c of both branches counts, as the paper's gains do not
    follow strain.
    """
    middle = len(plant.resistance_ohm) // 2
    resistance = plant.resistance_ohm[middle]
    total = resistance + plant.shunt_resistance_ohm
    power = plant.heating_power_w[middle]
    volts_per_watt = total / (2.0 * math.sqrt(power * resistance))
    gain_w = float(min(row.min() for row in feedback_gains(plant)))
    return gain_w * error_unit_for(model) * volts_per_watt / MIDDLE_KP
