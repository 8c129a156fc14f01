"""Where a reference is faster than its wire heats or cools, how far the wire gets, and what would help by how much."""

from __future__ import annotations

import math
from collections.abc import Callable, Set
from dataclasses import dataclass
from functools import partial
from itertools import pairwise
from typing import Literal, NamedTuple

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.controllers import FeedforwardSettings, Reference, Staircase
from musclewire.errors import CallerError
from musclewire.identify._speed_limits.plant import (
    SpeedPlant,
    branches_of,
    fastest_course,
    plant_of_gains,
    plant_of_model,
    towards,
)
from musclewire.identify._speed_limits.supply import LATE_PCT, WeakSupply, min_errors_pct, warming_s
from musclewire.identify._use_of_model import alloy_of
from musclewire.parameters import Alloy, section_m2, validity_of
from musclewire.physics import convection_coefficient_w_per_m2_k
from musclewire.sensing import SHOWN_AS, SensingModel
from musclewire.signals import RunFacts

Misses = Callable[[SpeedPlant, float], FloatArray]

MAX_FACTOR = 16.0  # by which speed, voltage or loss is changed: a larger change is no advice
BISECTIONS = 9  # of that factor's logarithm, which is then known to 0.5 %
# The thinnest wire that vendors list.
THINNEST_M = 25e-6
# Temperature at which losses to the air are compared: that of a contracted wire.
HOT_K = 373.15
# Heat that a voltage without limit gives, for what only cooling limits.
AMPLE = 100.0


class SufficientChanges(NamedTuple):
    """What each change alone must be, so that the wire follows; None if it is not needed or does not suffice."""

    slower: float | None = None  # factor by which the whole reference takes longer
    heat_loss: float | None = None  # factor on the heat loss to the air, as by moving air
    diameter_m: float | None = None  # at the same stress
    # Power of the diameter with which loss over capacity goes, between both diameters.
    diameter_power: float | None = None
    pull: float | None = None  # force of that wire over the force of this one
    # Added by an antagonist while the wire cools, which raises its transformation temperatures.
    antagonist_stress_pa: float | None = None
    voltage: float | None = None  # factor on the maximum voltage, for heating

    def text(self, direction: str) -> str:
        """Return what helps cooling or heating, in words with numbers."""
        ways = []
        if direction == "heating":
            if self.voltage is not None:
                ways.append(f"{self.voltage:.2f} times the maximum voltage, within the wire's limits")
        elif self.heat_loss is not None:
            ways.append(f"{self.heat_loss:.2g} times the heat loss (moving air)")
        if direction == "cooling" and self.diameter_m is not None and self.pull is not None:
            ways.append(
                f"a wire of {1e6 * self.diameter_m:.0f} um (loss over capacity is proportional to diameter to the "
                f"power {self.diameter_power:.1f}; its pull falls to {100 * self.pull:.0f} %)"
            )
        if direction == "cooling" and self.antagonist_stress_pa is not None:
            ways.append(f"an antagonist that adds {1e-6 * self.antagonist_stress_pa:.0f} MPa while the wire cools")
        if self.slower is not None:
            ways.append(f"a reference {self.slower:.3g} times slower")
        return ", or ".join(ways) or f"no single change by less than {MAX_FACTOR:g} times; a smaller amplitude"


def what_helps(
    plant: SpeedPlant, misses: Misses, tolerance: float, slow: Set[str], model: SensingModel, facts: RunFacts
) -> SufficientChanges:
    """Return what each change alone must be; ``misses`` are those of a plant on the reference taken slower."""
    if not slow:
        return SufficientChanges()

    def follows(changed: SpeedPlant, slower: float = 1.0, sides: Set[str] = slow) -> bool:
        missed = misses(changed, slower)
        cools = "cooling" not in sides or bool((missed <= tolerance).all())
        return cools and ("heating" not in sides or bool((missed >= -tolerance).all()))

    found = SufficientChanges(slower=smallest(partial(follows, plant), MAX_FACTOR))
    if "heating" in slow:
        heats = {"heating"}
        found = found._replace(voltage=smallest(lambda x: follows(plant.with_voltage(x), sides=heats), MAX_FACTOR))
    if "cooling" not in slow:
        return found
    cools, ample = {"cooling"}, plant.with_voltage(AMPLE)
    loss = smallest(lambda x: follows(ample.with_loss(x), sides=cools), MAX_FACTOR)
    stress = stress_pa(lambda power_w: follows(ample.with_warmer_cooling(power_w), sides=cools), model, facts)
    return found._replace(heat_loss=loss, antagonist_stress_pa=stress, **thinner(loss, facts))


def stress_pa(follows: Callable[[float], bool], model: SensingModel, facts: RunFacts) -> float | None:
    """Return the stress [Pa] by which the cooling branch is warm enough to follow, None if the vendor's is too low.

    ``follows`` takes the power [W] by which the branch is warmer: stress over C_M (Clausius-Clapeyron), times the loss.
    """
    alloy = alloy_of(model)
    per_pa = facts.limit_heat_loss_w_per_k / alloy.martensite_stress_rate_pa_per_k.value
    room_pa = room_for_stress_pa(alloy, facts)
    factor = smallest(lambda x: follows((x - 1.0) * room_pa * per_pa), 2.0)
    return None if factor is None else (factor - 1.0) * room_pa


def smallest(follows: Callable[[float], bool], largest: float) -> float | None:
    """Return the smallest factor from 1 on with which a wire follows, None if the largest is not enough."""
    if not follows(largest):
        return None
    low, high = 0.0, math.log(largest)
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if follows(math.exp(middle)) else (middle, high)
    return math.exp(high)


def room_for_stress_pa(alloy: Alloy, facts: RunFacts) -> float:
    """Return the stress [Pa] that may be added to that of the pretension within the vendor's; 0 at least."""
    diameter, pretension = facts.positive_or_none("wire_diameter_m"), facts.number_or_none("pretension_n")
    working = validity_of(alloy).working_stress_pa
    if working is None:
        return 0.0
    if diameter is None or pretension is None:
        return working
    whole, leg = facts.positive_or_none("wire_length_m"), facts.leg_length_or_none_m
    legs = 1.0 if whole is None or leg is None else whole / leg
    return max(working - pretension / section_m2(diameter, legs), 0.0)


def thinner(loss: float | None, facts: RunFacts) -> dict[str, float]:
    """Return diameter, power and pull of a wire that loses heat so many times as fast; none if no wire does."""
    diameter = facts.positive_or_none("wire_diameter_m")
    ambient_k = facts.positive_or_none("limit_ambient_temperature_k")
    if loss is None or diameter is None or ambient_k is None:
        return {}
    found = diameter_for(loss, diameter, ambient_k)
    if found < THINNEST_M:
        return {}
    power = math.log(loss) / math.log(found / diameter) if found < diameter else float("nan")
    return {"diameter_m": found, "diameter_power": power, "pull": (found / diameter) ** 2}


def diameter_for(factor: float, diameter_m: float, ambient_k: float) -> float:
    """Return the diameter [m] at which loss over capacity in still air is so many times that of another one."""

    def per_capacity(one_m: float) -> float:
        return float(convection_coefficient_w_per_m2_k(HOT_K, ambient_k, one_m)) / one_m

    grid = np.geomspace(diameter_m / 32.0, diameter_m, 400)
    ratio = np.array([per_capacity(float(one)) for one in grid]) / per_capacity(diameter_m)
    return float(np.exp(np.interp(-math.log(factor), -np.log(ratio), np.log(grid))))


# The wire misses its target from this fraction of the model's range on. Chosen: near the largest error in the paper.
TOLERANCE_FRACTION = 0.02
# A reference that lasts longer is looked at in longer periods than the rig's.
MAX_PERIODS = 40_000
# What would help is searched in this many periods around the worst miss.
PERIODS_FOR_HELP = 3000
# A reference with this many turns is periodic: its first half, which begins at rest, is left out of amplitudes.
FEWEST_TURNS = 4
# From this fraction of the amplitude on the wire misses only where the reference begins.
IN_STEP = 0.95


class TooFast(NamedTuple):
    """One stretch of a reference that the wire cannot follow."""

    direction: Literal["cooling", "heating"]  # what is too slow
    start_s: float  # start of the first missed target in the reference
    stop_s: float  # end of the last missed one
    missed: float  # largest distance from a target at its end, in the quantity's SI unit
    asked_per_s: float  # largest rate of the reference there, a step counted over the time that it is held
    possible_per_s: float  # of the wire on its branch where it misses most
    # Standstill when the wire turns there, from branch to branch; infinite where the voltage holds it for good.
    turn_s: float


@dataclass(frozen=True)
class SpeedLimits:
    """Where a reference is too fast for a wire, which amplitude is possible, and what would help."""

    quantity: str  # "strain", "displacement" or "force": the unit of all amplitudes
    # The stretches that the wire cannot follow, in their order; none for a reference that it can.
    findings: tuple[TooFast, ...]
    asked_amplitude: float  # half the distance from the lowest to the highest target, in the quantity's SI unit
    possible_amplitude: float  # the same of the way on which the wire can follow at best
    help: SufficientChanges  # what each single change would have to be, so that the wire follows
    # The step of a staircase that the supply makes latest, if the run begins from cold; None if it suffices.
    supply: WeakSupply | None = None

    @property
    def warnings(self) -> tuple[str, ...]:
        """One sentence for cooling, heating and a supply too weak from cold each, if it is so; none otherwise."""
        directions: tuple[Literal["cooling", "heating"], ...] = ("cooling", "heating")
        found = tuple(self._warning(one) for one in directions if any(f.direction == one for f in self.findings))
        return found if self.supply is None else (*found, self.supply.text(self.quantity))

    def __str__(self) -> str:
        """Return the warnings, or one line that says that there are none."""
        return "\n".join(self.warnings) or "the wire can follow this reference"

    def _warning(self, direction: Literal["cooling", "heating"]) -> str:
        """Return the sentence on one direction."""
        factor, unit = SHOWN_AS[self.quantity]
        found = [one for one in self.findings if one.direction == direction]
        worst = max(found, key=lambda one: one.missed)
        times = "" if len(found) == 1 else f", and {len(found) - 1} times more"
        verb, limit = ("falls", "cools") if direction == "cooling" else ("rises", "heats at its maximum voltage")
        possible, asked = factor * self.possible_amplitude, factor * self.asked_amplitude
        in_step = " once it is in step" if possible >= IN_STEP * asked else ""
        asked_rate, rate = factor * worst.asked_per_s, factor * worst.possible_per_s
        return (
            f"the reference {verb} faster than the wire {limit}: from {found[0].start_s:.3g} s on{times} it will miss "
            f"its target, by up to {factor * worst.missed:.2g} {unit}; it is to move at {asked_rate:.2g} {unit}/s, and "
            f"it moves at {rate:.2g} {unit}/s there and stands still for {worst.turn_s:.2g} s where it turns. "
            f"The wire itself allows an amplitude of {possible:.2g} of {asked:.2g} {unit}{in_step}, "
            f"a controller less. What would help: {self.help.text(direction)}"
        )


class SampledTargets(NamedTuple):
    """A reference in even periods: time between them [s], the targets, (n,), and where each ends to be held, (n,)."""

    period_s: float
    targets: FloatArray

    @property
    def held_until(self) -> FloatArray:
        """Index of the last period of each target that is held."""
        return np.append(np.flatnonzero(np.diff(self.targets)), len(self.targets) - 1)

    def misses(self, plant: SpeedPlant) -> FloatArray:
        """Return by how much the wire is above each held target when that ends, (n_held,)."""
        last = self.held_until
        return np.asarray((fastest_course(plant, self.targets, self.period_s) - self.targets)[last])


def speed_limits_of(
    model: SensingModel,
    reference: Reference,
    facts: RunFacts,
    settings: FeedforwardSettings | None = None,
    *,
    from_cold: bool = False,
) -> SpeedLimits:
    """Return where a reference is faster than the wire of a model; the pure function behind ``mw.speed_limits``.

    ``facts`` are what a rig states of its protection (limits of heat, temperature and voltage, shunt), of its sample
    period and of the wire's diameter. Without ``settings`` the plant is that of the model's slow loop. Raises
    CallerError if the settings are of another quantity. Raises RecordingError if the model has no power through its
    loop, or the rig does not state its limits.
    """
    if settings is not None and settings.quantity != model.quantity:
        raise CallerError(f"the gains are for {settings.quantity}, the model for {model.quantity}: tune this model")
    plant = plant_of_model(model, facts) if settings is None else plant_of_gains(settings, facts)
    way = sampled(reference, facts.sample_period_s)
    tolerance = TOLERANCE_FRACTION * (model.quantity_max - model.quantity_min)
    reached = fastest_course(plant, way.targets, way.period_s)
    found = findings_of(plant, way, reached, tolerance)
    turns = np.count_nonzero(np.diff(np.sign(np.diff(way.targets[way.held_until]))))
    settled = slice(len(reached) // 2 if turns >= FEWEST_TURNS else 0, None)
    return SpeedLimits(
        model.quantity,
        found,
        0.5 * float(np.ptp(way.targets[settled])),
        0.5 * float(np.ptp(reached[settled])),
        what_helps(
            plant, partial(misses, around(way, found)), tolerance, {one.direction for one in found}, model, facts
        ),
        weak_supply(plant, reference, facts, settings) if from_cold and isinstance(reference, Staircase) else None,
    )


class FastestWay:
    """How far from its target a wire is, sample by sample, if nothing but its speed limits holds it back.

    Without ``settings`` the plant is that of the model's slow loop; the wire is at its first target unless
    ``from_cold``. Raises RecordingError if the model has no power through its loop, or the rig does not state its
    limits.
    """

    def __init__(
        self, model: SensingModel, facts: RunFacts, settings: FeedforwardSettings | None = None, *, from_cold: bool
    ) -> None:
        """Begin at rest."""
        self._plant = plant_of_model(model, facts) if settings is None else plant_of_gains(settings, facts)
        self._heating, self._cooling = branches_of(self._plant)
        self._period_s = facts.sample_period_s
        dead_time_s = self._period_s if settings is None else settings.dead_time_s
        self._cold_s = warming_s(self._plant, dead_time_s) if from_cold else 0.0
        self._level = float(self._plant.levels[0]) if from_cold else math.nan
        self._power_w = self._heating.power_w(self._level)

    def miss(self, target: float) -> float:
        """Return how far the wire is at best above a target after a sample; 0 if the voltage takes it no farther."""
        within = float(np.clip(target, self._plant.levels[0], self._plant.levels[-1]))
        if self._cold_s > 0.0:
            self._cold_s -= self._period_s
            return -target
        if math.isnan(self._level):
            self._level, self._power_w = within, self._heating.power_w(within)
        if within != self._level:
            branch = self._heating if within > self._level else self._cooling
            if branch.ends_at(self._level, rising=within > self._level):
                return 0.0
            way = (within, self._period_s, self._plant.time_constant_s)
            self._level, self._power_w = towards(branch, self._level, self._power_w, way)
        return self._level - within


def weak_supply(
    plant: SpeedPlant, steps: Staircase, facts: RunFacts, settings: FeedforwardSettings | None
) -> WeakSupply | None:
    """Return the step that the supply makes latest from cold; None if it is late for none."""
    period_s, maximum_v = facts.sample_period_s, facts.number("limit_maximum_voltage_v", "maximum voltage of the rig")
    dead_time_s = period_s if settings is None else settings.dead_time_s

    def errors_pct(factor: float) -> FloatArray:
        return min_errors_pct(plant.with_voltage(factor), steps, period_s, dead_time_s)

    now = errors_pct(1.0)
    worst = steps.steps[int(np.argmax(now))]
    if float(now.max()) <= LATE_PCT:
        return None
    factor = smallest(lambda x: bool(errors_pct(x).max() <= LATE_PCT), MAX_FACTOR)
    enough_v = None if factor is None else factor * maximum_v
    return WeakSupply(worst.index + 1, worst.start_s, worst.target, float(now.max()), maximum_v, enough_v)


def misses(way: SampledTargets, plant: SpeedPlant, slower: float) -> FloatArray:
    """Return the misses of a plant on a way that is taken so many times slower."""
    return way._replace(period_s=slower * way.period_s).misses(plant)


def around(way: SampledTargets, found: tuple[TooFast, ...]) -> SampledTargets:
    """Return the part of a long reference around its worst miss, by which help is found; a short one whole."""
    if not found or len(way.targets) <= PERIODS_FOR_HELP:
        return way
    worst = max(found, key=lambda one: one.missed)
    begins = max(round(worst.stop_s / way.period_s) - PERIODS_FOR_HELP // 2, 0)
    return way._replace(targets=way.targets[begins : begins + PERIODS_FOR_HELP])


def sampled(reference: Reference, sample_period_s: float) -> SampledTargets:
    """Return a reference in periods of the rig, or in longer ones if there were too many."""
    count = min(max(round(reference.duration_s / sample_period_s), 1), MAX_PERIODS)
    period_s = reference.duration_s / count
    return SampledTargets(period_s, reference.targets_at(period_s * np.arange(count)))


def findings_of(plant: SpeedPlant, way: SampledTargets, reached: FloatArray, tolerance: float) -> tuple[TooFast, ...]:
    """Return each stretch of held targets that are missed to one side."""
    last = way.held_until
    first = np.append(0, last[:-1] + 1)
    missed = (reached - way.targets)[last]
    side = np.sign(missed) * (np.abs(missed) > tolerance)
    before = np.append(way.targets[0], way.targets[last][:-1])
    rate = np.abs(way.targets[last] - before) / ((last - first + 1) * way.period_s)
    begins = np.flatnonzero(np.diff(side, prepend=0.0) != 0.0)
    found = []
    for begin, end in pairwise([*begins.tolist(), len(side)]):
        if side[begin] == 0.0:
            continue
        worst = begin + int(np.argmax(np.abs(missed[begin:end])))
        times_s = (float(first[begin] * way.period_s), float((last[end - 1] + 1) * way.period_s))
        cooling, level = bool(side[begin] > 0.0), float(reached[last[worst]])
        speeds = (float(rate[begin:end].max()), rate_at(plant, level, cooling), turn_at(plant, level, cooling))
        found.append(TooFast("cooling" if cooling else "heating", *times_s, float(abs(missed[worst])), *speeds))
    return tuple(found)


def rate_at(plant: SpeedPlant, level: float, cooling: bool) -> float:
    """Return the rate [unit/s] of the wire on a branch at a level."""
    times_s = plant.cooling_times_s() if cooling else plant.heating_times_s()
    place = int(np.clip(np.searchsorted(plant.levels, level), 1, len(times_s) - 1))
    spacing = float(plant.levels[place] - plant.levels[place - 1])
    return spacing / max(float(times_s[place] - times_s[place - 1]), 1e-12)


def turn_at(plant: SpeedPlant, level: float, cooling: bool) -> float:
    """Return the time [s] in which a wire that turns at a level goes from one branch to the other."""
    heating, cools = branches_of(plant)
    onto, power_w = (cools, heating.power_w(level)) if cooling else (heating, cools.power_w(level))
    return onto.time_to(power_w, level, plant.time_constant_s)
