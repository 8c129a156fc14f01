"""What the benchmark runs, and its bars, from its data files: population, runs, conditions, checked by schema."""

from __future__ import annotations

import tomllib
from functools import cache
from importlib.resources import files
from typing import Literal

from pydantic import BaseModel, ConfigDict, Field, model_validator

from musclewire import CallerError
from musclewire.errors import nearest_hint
from musclewire.parameters import validated

SETTINGS_FILE = "settings.toml"


class StrictTable(BaseModel):
    """A table of the file: an unknown key is an error."""

    model_config = ConfigDict(extra="forbid", frozen=True)


class BaseWire(StrictTable):
    """A wire as it is sold, and the pretension that the command recommends for it."""

    wire: str
    pretension_n: float = Field(gt=0.0)


class StructureSpread(StrictTable):
    """What a wire of the population is made of, which no model of its user has.

    Parameters
    ----------
    grains
        Normal populations of grains: weight, mean offset and deviation, in units of the alloy's spread.
    grains_std
        Standard deviation of each of the three, from wire to wire.
    barrier_weights
        Fractions of the grains in each class of barrier.
    barriers_k
        Barrier of each class beyond the alloy's [K].
    barriers_std
        Relative standard deviation of it, from wire to wire.
    segment_temperature_k
        Standard deviation of the transformation temperatures along a wire in segments [K].
    segment_convection
        That of convection along it, relative.
    ageing
        Numbers of the ageing by use.
    """

    grains: tuple[tuple[float, float, float], ...] = Field(min_length=2)
    grains_std: tuple[float, float, float]
    barrier_weights: tuple[float, ...] = Field(min_length=2)
    barriers_k: tuple[float, ...]
    barriers_std: float
    segment_temperature_k: float
    segment_convection: float
    ageing: dict[str, float]


class Population(StrictTable):
    """Seeds, and how far their wires spread around what is sold."""

    held_out_seeds: tuple[int, ...] = Field(min_length=20)
    tuning_seeds: tuple[int, ...] = Field(min_length=1)
    quick_seeds: tuple[int, ...] = Field(min_length=1)
    segments: int = Field(ge=10)
    pretension_ratios: tuple[float, ...] = Field(min_length=2)
    base: tuple[BaseWire, ...] = Field(min_length=3)
    wire_std: dict[str, str]
    bench_std: dict[str, str]
    alloy_std: dict[str, str]
    structure: StructureSpread

    @model_validator(mode="after")
    def _nobody_tunes_on_what_is_reported(self) -> Population:
        both = set(self.held_out_seeds) & set(self.tuning_seeds)
        if both:
            raise ValueError(f"seeds {sorted(both)} are held out and for tuning: a seed is one or the other")
        return self


class RigSettings(StrictTable):
    """What a rig of the population allows."""

    maximum_voltage_ratio: float = Field(ge=1.0)
    board_voltage_ratio: float = Field(ge=1.0)
    noisy_jump_fraction: float = Field(gt=0.0, lt=1.0)
    moving_air_limit_k: float = Field(gt=0.0)


class RunSettings(StrictTable):
    """Times of a run, and the range in which it is judged."""

    start_up_s: float = Field(gt=0.0)
    reference_s: float = Field(gt=0.0)
    change_at_s: float = Field(gt=0.0)
    ramp_s: float = Field(gt=0.0)
    drift_s: float = Field(gt=0.0)
    judged_after_s: float = Field(gt=0.0)
    zeroing_s: float = Field(gt=0.0)
    usable_low: float = Field(gt=0.0, lt=1.0)
    usable_high: float = Field(gt=0.0, le=1.0)


class Characterization(StrictTable):
    """What a user records and how long his calibration searches."""

    random_steps_s: float = Field(gt=0.0)
    starts: int = Field(ge=1)
    jumps: int = Field(ge=0)
    evaluations_each: int = Field(ge=1)
    evaluations_last: int = Field(ge=1)


class QuickRun(StrictTable):
    """What a quick run has."""

    conditions: tuple[str, ...] = Field(min_length=1)
    references: tuple[str, ...] = Field(min_length=1)


class Condition(StrictTable):
    """What is changed in a run, and which bar its rows are held to.

    Parameters
    ----------
    name
        Name of the row.
    bar
        Name of the bar.
    ambient_k
        By how much the air is warmer [K].
    convection_factor
        Factor on the loss to the air.
    draughts
        Standard deviation of the convection in draughts, relative.
    load_fraction
        A constant force at the connector, as a fraction of the pretension.
    stiffness_factor
        Factor on the spring's stiffness.
    pretension_fraction
        A change of the pretension, as a fraction of it.
    resistance_factor
        Factor on the wire's resistance.
    transformation_shift_k
        Shift of the transformation temperatures [K].
    lead_ohm
        Resistance of leads within the measured voltage [ohm].
    noise_factor
        Factor on the noise of the converter.
    bits
        Bits of the converter; the bench's own if None.
    wire_range_v, shunt_range_v
        Ranges of the converter for both voltages [V]; the bench's own if None.
    one_sided
        Whether the converter's range begins at 0.
    readings
        Readings in a sample; the bench's own if None.
    jitter
        Standard deviation of the time between two samples, relative.
    contact_fraction
        Jumps of a contact's resistance, as a fraction of the wire's.
    drift
        Whether all of it comes slowly.
    home
        Whether what can drift is there from the beginning and a home move comes before everything else.
    thermometer
        Whether the home move knows the temperature of the air.
    zeroed
        Whether all of it is there from the beginning, and the zero of the displacement is taken again under it.
    rest_s
        For how long the wire rests without heat from the change on [s].
    flag_s
        Time [s] within which a flag has to come; None if none is asked for.
    """

    name: str = Field(min_length=1)
    bar: str = Field(min_length=1)
    ambient_k: float = 0.0
    convection_factor: float = Field(default=1.0, gt=0.0)
    draughts: float = Field(default=0.0, ge=0.0)
    load_fraction: float = 0.0
    stiffness_factor: float = Field(default=1.0, gt=0.0)
    pretension_fraction: float = 0.0
    resistance_factor: float = Field(default=1.0, gt=0.0)
    transformation_shift_k: float = 0.0
    lead_ohm: float = Field(default=0.0, ge=0.0)
    noise_factor: float = Field(default=1.0, gt=0.0)
    bits: int | None = Field(default=None, ge=1)
    wire_range_v: float | None = Field(default=None, gt=0.0)
    shunt_range_v: float | None = Field(default=None, gt=0.0)
    one_sided: bool = False
    readings: int | None = Field(default=None, ge=1)
    jitter: float = Field(default=0.0, ge=0.0, lt=0.3)
    contact_fraction: float = Field(default=0.0, ge=0.0)
    drift: bool = False
    home: bool = False
    thermometer: bool = False
    zeroed: bool = False
    rest_s: float = Field(default=0.0, ge=0.0)
    flag_s: float | None = Field(default=None, gt=0.0)

    @property
    def disturbance(self) -> str:
        """What is changed: the first word of the name."""
        return self.name.partition(" ")[0]

    @property
    def level(self) -> str:
        """By how much, and whether a home move follows: the rest of the name."""
        return self.name.partition(" ")[2]

    @property
    def undisturbed(self) -> bool:
        """Whether nothing is changed."""
        return self == Condition(name=self.name, bar=self.bar)

    @property
    def moves_zero(self) -> bool:
        """Whether the cold wire has another length under it, so that a new zero differs from the old one."""
        return bool(self.load_fraction or self.pretension_fraction)

    @property
    def changes_load(self) -> bool:
        """Whether what the wire pulls changes."""
        return self.moves_zero or self.stiffness_factor != 1.0

    @property
    def changes_air(self) -> bool:
        """Whether the air changes."""
        return bool(self.ambient_k or self.draughts) or self.convection_factor != 1.0


class GripCondition(StrictTable):
    """What is other in a grip than at the gripper's training.

    Parameters
    ----------
    name
        Name of the row.
    ambient_k
        By how much the air is warmer [K].
    convection_factor
        Factor on the loss to the air.
    draughts
        Standard deviation of the convection in draughts, relative; 0 for those of the rig's file.
    object_factor
        Factor on the object's stiffness.
    resistance_factor
        Factor on the wires' resistance.
    transformation_shift_k
        Shift of their transformation temperatures [K].
    noise_factor
        Factor on the noise of the converter.
    """

    name: str = Field(min_length=1)
    ambient_k: float = 0.0
    convection_factor: float = Field(default=1.0, gt=0.0)
    draughts: float = Field(default=0.0, ge=0.0, le=0.25)
    object_factor: float = Field(default=1.0, gt=0.0)
    resistance_factor: float = Field(default=1.0, gt=0.0)
    transformation_shift_k: float = 0.0
    noise_factor: float = Field(default=1.0, gt=0.0)


class GripRuns(StrictTable):
    """Grips under disturbance: their seeds, and what is other than at the training."""

    seeds: tuple[int, ...] = Field(min_length=1)
    condition: tuple[GripCondition, ...] = Field(min_length=1)


class RobustnessSettings(StrictTable):
    """The whole file."""

    population: Population
    rig: RigSettings
    run: RunSettings
    characterization: Characterization
    quick: QuickRun
    grips: GripRuns
    condition: tuple[Condition, ...] = Field(min_length=1)

    def conditions(self, names: tuple[str, ...] | None = None) -> tuple[Condition, ...]:
        """Return conditions by name, all if None. Raises CallerError for an unknown one, suggesting the nearest."""
        known = {item.name: item for item in self.condition}
        for name in names or ():
            if name not in known:
                raise CallerError(f"there is no condition '{name}'{nearest_hint(name, known)}")
        return self.condition if names is None else tuple(known[name] for name in names)


@cache
def settings() -> RobustnessSettings:
    """Return the settings that ship with musclewire."""
    text = (files("musclewire_robustness") / "data" / SETTINGS_FILE).read_text("utf-8")
    return validated(RobustnessSettings, tomllib.loads(text), f"robustness: {SETTINGS_FILE}")


BARS_FILE = "bars.toml"


class RowBar(StrictTable):
    """The bar of one kind of condition.

    Parameters
    ----------
    bar
        Its name, as conditions have it.
    polynomial_prototype_pct
        What the polynomial reached in the study of prototypes [%]; None if it was not run there.
    max_pct
        Largest error [%]; None for a row that is only reported.
    segmented_max_pct
        The same for wires in segments, where it differs.
    honest
        Whether intervals and validity are judged.
    """

    bar: str
    polynomial_prototype_pct: float | None = None
    max_pct: float | None = Field(default=None, gt=0.0)
    segmented_max_pct: float | None = Field(default=None, gt=0.0)
    honest: bool = True


class HonestBars(StrictTable):
    """Bars of intervals and validity, as fractions."""

    coverage_low: float
    coverage_high: float
    beyond_5_share: float
    valid_undisturbed: float
    valid_changed: float
    valid_before_b: float


class FlagBars(StrictTable):
    """Bars of flags."""

    in_time_fraction: float
    false_per_hour: float


class RobustnessBars(StrictTable):
    """The whole file."""

    default_estimator: str
    baseline_estimator: str
    baseline_fraction: float
    worst_wire_ratio: float
    gap_without_allowance_pct: float
    row: tuple[RowBar, ...]
    honest: HonestBars
    flags: FlagBars

    def bar_named(self, name: str) -> RowBar:
        """Return the bar of a kind of condition; one without a table is only reported."""
        return next((item for item in self.row if item.bar == name), RowBar(bar=name))

    def allowance(self, gap_pct: float) -> float:
        """Return by how much the bar of a wire is multiplied for the gap of its slow loop [%]."""
        return max(1.0, gap_pct / self.gap_without_allowance_pct)


@cache
def bars() -> RobustnessBars:
    """Return the bars that ship with musclewire."""
    text = (files("musclewire_robustness") / "data" / BARS_FILE).read_text("utf-8")
    return validated(RobustnessBars, tomllib.loads(text), f"robustness: {BARS_FILE}")


KNOWN_MISSES_FILE = "known_misses.toml"


class KnownMiss(StrictTable):
    """Bars that are known to be missed for one reason.

    Parameters
    ----------
    reason
        Why they are missed.
    whose
        Whether resistance alone cannot show it (physics), or a better estimator could (ours).
    bars
        Their full names: condition and what is judged.
    runs
        Of which runs that is known.
    """

    reason: str = Field(min_length=20)
    whose: Literal["physics", "ours"]
    bars: tuple[str, ...] = Field(min_length=1)
    runs: Literal["quick", "whole", "both"] = "both"


class KnownMisses(StrictTable):
    """The whole file."""

    miss: tuple[KnownMiss, ...]

    def reasons(self, *, quick: bool) -> dict[str, str]:
        """Return the reasons by full name for a quick run, or for one that is not, each with whose it is."""
        runs = ("both", "quick" if quick else "whole")
        found: dict[str, str] = {}
        for one in self.miss:
            if one.runs in runs:
                if twice := found.keys() & set(one.bars):
                    raise ValueError(f"{', '.join(sorted(twice))}: a bar has one reason, leave the other out")
                said = "physics" if one.whose == "physics" else "ours to mend"
                found |= dict.fromkeys(one.bars, f"{said}: {one.reason}")
        return found

    @model_validator(mode="after")
    def _one_reason_each(self) -> KnownMisses:
        for quick in (True, False):
            self.reasons(quick=quick)
        return self


@cache
def known_misses() -> KnownMisses:
    """Return the committed list of bars that are known to be missed."""
    text = (files("musclewire_robustness") / "data" / KNOWN_MISSES_FILE).read_text("utf-8")
    return validated(KnownMisses, tomllib.loads(text), f"robustness: {KNOWN_MISSES_FILE}")
