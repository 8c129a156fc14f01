"""What the commands of the core print with --json."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any, Self

from pydantic import AliasGenerator, ConfigDict, Field

from musclewire.app._answer import ABSENT, AnswerModel, AnswerRecord, Finite
from musclewire.controllers import ProtectionLimits, ProtectionTable, RuleBase
from musclewire.experiment import (
    ChannelCalibration,
    ControlMetrics,
    PretensionRow,
    RigCheck,
    SkippedCheck,
    StepSpread,
    TrainingCycle,
)
from musclewire.files import IgnoredHeader, MatchedHeader, UndecidedHeader
from musclewire.identify import SufficientChanges, TooFast, WeakSupply
from musclewire.judge import ErrorGroup
from musclewire.sensing import HomeMove
from musclewire.signals import MetadataValue

Words = tuple[str, ...]


class StepErrorsAnswer(AnswerModel):
    """Errors of one step of a staircase, in percent of its target."""

    direction: str
    mae_pct: float | None
    mae_approached_pct: float | None
    estimate_mae_pct: float | None
    estimate_mae_approached_pct: float | None
    tracking_mae_pct: float | None
    tracking_mae_approached_pct: float | None


class StrainTarget(AnswerModel):
    """A target of strain."""

    target_pct: float


class DisplacementTarget(AnswerModel):
    """A target of displacement."""

    target_m: float


class ForceTarget(AnswerModel):
    """A target of force."""

    target_n: float


# The fields of the last class come first.
class StrainStep(StepErrorsAnswer, StrainTarget):
    """A step of strain."""


class DisplacementStep(StepErrorsAnswer, DisplacementTarget):
    """A step of displacement."""


class ForceStep(StepErrorsAnswer, ForceTarget):
    """A step of force."""


# Of each quantity the model of a step, the key of its target, and the factor of that from SI.
STEPS: dict[str, tuple[type[StepErrorsAnswer], str, float]] = {
    "strain": (StrainStep, "target_pct", 100.0),
    "displacement": (DisplacementStep, "target_m", 1.0),
    "force": (ForceStep, "target_n", 1.0),
}


class LoopErrors(AnswerModel):
    """Errors of a closed loop."""

    steps: tuple[StrainStep | DisplacementStep | ForceStep, ...]
    mae_max_pct: float | None
    mae_mean_pct: float | None
    mae_max_approached_pct: float | None
    mae_mean_approached_pct: float | None
    approach_s: float
    approach: str
    valid_share: float
    rms_pct: float | None
    estimate_rms_pct: float | None
    tracking_rms_pct: float

    @classmethod
    def of_run(cls, metrics: ControlMetrics, **named: Any) -> Self:
        """Return an answer with the errors of a run."""
        kind, key, factor = STEPS[metrics.quantity]
        steps = [kind.read_from(step, **{key: round(factor * step.target, 10)}) for step in metrics.steps]
        return cls.read_from(metrics, steps=steps, **named)


class FittedRange(AnswerModel):
    """The gap and the range of a fitted model."""

    strain_gap_pct: float
    resistance_min_ohm: float
    resistance_max_ohm: float


class DemoAnswer(LoopErrors, FittedRange):
    """Of ``demo``."""

    best_pretension_n: float | None
    time_step_s: float
    warnings: Words
    seed: int
    wall_s: float
    report: str


class Percentiles(AnswerModel):
    """Percentiles of times [us]."""

    p50: float
    p99: float
    p999: float


class SpeedLimitsAnswer(AnswerModel):
    """Where a reference is faster than the wire."""

    quantity: str
    findings: tuple[Annotated[TooFast, AnswerRecord(turn_s=Finite)], ...]
    asked_amplitude: float
    possible_amplitude: float
    help: Annotated[SufficientChanges, AnswerRecord()]
    supply: Annotated[WeakSupply, AnswerRecord()] | None


@dataclass(frozen=True, kw_only=True)
class HomeFound(HomeMove):
    """A home move, and what its sweep showed."""

    resistance_max_moved_ohm: float
    resistance_max_moved_std_ohm: float
    resistance_min_moved_ohm: float
    resistance_min_moved_std_ohm: float
    warming_moved_k: float
    misfit_ohm: float
    saw_b_cooling: bool
    saw_c: bool
    notes: Words


class LoopFinding(AnswerModel):
    """A cause that was found in a closed loop; a grave one is why its result does not hold."""

    cause: str
    from_s: float
    lasted_s: float
    grave: bool
    numbers: str


class ControlRunAnswer(LoopErrors):
    """Of ``control``."""

    deadline_misses: int
    jitter_us: Percentiles | None
    latency_us: Percentiles | None
    compute_us: Percentiles | None
    drift_us: float | None
    known_stiffness_n_per_m: float | None
    known_friction_n: float | None
    estimator: str | None
    controller: str | None
    health: str
    findings: tuple[LoopFinding, ...]
    ended: str
    samples: int
    warnings: Words
    speed_limits: SpeedLimitsAnswer | None
    home: HomeFound | None


class LoopRunAnswer(AnswerModel):
    """One of many closed loops; its errors are null if it did not reach its end."""

    seed: int
    ended: str
    compiled: bool
    mae_pct: tuple[float | None, ...] | None = None
    mae_approached_pct: tuple[float | None, ...] | None = None
    mae_max_pct: float | None = None
    mae_mean_pct: float | None = None
    mae_max_approached_pct: float | None = None
    mae_mean_approached_pct: float | None = None
    rms_pct: float | None = None
    valid_share: float | None = None
    warnings: Words
    does_not_hold: str


class ManyLoopsAnswer(AnswerModel):
    """Of ``control --runs``."""

    approach_s: float | None
    approach: str | None
    steps: tuple[Annotated[StepSpread, AnswerRecord(infinite=...)], ...]
    runs: tuple[LoopRunAnswer, ...]


ControlAnswers = ControlRunAnswer | ManyLoopsAnswer


@dataclass(frozen=True, kw_only=True)
class HomeAnswer(HomeFound):
    """Of ``home``."""

    model: str
    warnings: Words


class CharacterizeAnswer(AnswerModel):
    """Of ``characterize``; without an instrument or a loop the gaps are null, which a note or problem says."""

    recording: str
    samples: int
    strain_gap_pct: float | None = None
    displacement_gap_pct: float | None = None
    force_gap_pct: float | None = None
    stroke_pct: float | None = None
    no_force_gap: str = "no loop"
    amplitude_v: float | None
    amplitude_raised: str | None
    shows_c: bool | None
    warnings: Words
    note: str | None = ABSENT
    problem: str | None = ABSENT


class PretensionAnswer(AnswerModel):
    """Of ``pretension``."""

    rows: tuple[Annotated[PretensionRow, AnswerRecord(without=("recording",))], ...]
    best_pretension_n: float | None
    largest_pretension_n: float | None
    advice: str
    failures: Words
    warnings: Words


class TrainAnswer(AnswerModel):
    """Of ``train``."""

    settled: bool
    cycles: tuple[TrainingCycle, ...]
    warnings: Words


class DoctorAnswer(AnswerModel):
    """Of ``doctor``."""

    rig: str
    ok: bool
    checks: tuple[Annotated[RigCheck, AnswerRecord()], ...]
    unchecked: tuple[Annotated[SkippedCheck, AnswerRecord()], ...]
    calibration: tuple[Annotated[ChannelCalibration, AnswerRecord()], ...]
    highest_drive_voltage_v: float
    trouble: str | None
    written: str | None


PLURALS = {"state": "states", "effect": "effects", "signal": "signals", "event": "events"}


class ProtectionAnswer(ProtectionTable):
    """Of ``protection``: the table, and the limits of a rig but for infinite ones."""

    model_config = ConfigDict(alias_generator=AliasGenerator(serialization_alias=lambda key: PLURALS.get(key, key)))
    limits: Annotated[ProtectionLimits, AnswerRecord(infinite=ABSENT, readings_noisy=bool)] | None = ABSENT


class ImportedFile(AnswerModel):
    """How one file was understood."""

    path: str
    layout: str
    rows: int
    taken: tuple[MatchedHeader, ...]
    ignored: tuple[IgnoredHeader, ...]
    undecided: tuple[UndecidedHeader, ...]
    metadata: dict[str, MetadataValue]
    ranges: dict[str, tuple[float, float]]
    notes: Words
    problem: str


class JoinedFiles(AnswerModel):
    """How two files were joined on the first one's clock."""

    delay_s: float
    delay_std_s: float | None
    correlation: float | None
    columns: Words
    rows: int
    notes: Words
    rate: float = 1.0
    rate_std: float = 0.0
    how: str = ""


class ImportAnswer(AnswerModel):
    """Of ``import``."""

    files: tuple[ImportedFile, ...]
    join: JoinedFiles | None


class EstimateErrors(AnswerModel):
    """Errors of an estimate; null without an estimate, or without a reference."""

    valid_share: float | None = None
    estimator: str | None = None
    rms_pct: float | None = None
    max_pct: float | None = None
    wrong_pct: float | None = None
    no_reference: str | None = None
    not_counted: dict[str, float] = Field(default_factory=dict)
    error_groups: tuple[Annotated[ErrorGroup, AnswerRecord()], ...] = ()


class SampleCount(AnswerModel):
    """How many samples there are."""

    samples: int


class EstimateAnswer(EstimateErrors, SampleCount):
    """Of ``estimate``; ``fell_back`` is empty if the estimate is by the estimator that was asked for."""

    fell_back: str
    warnings: Words


class WireModelNumber(AnswerModel):
    """One number of a wire: value, standard deviation, and what it is known from."""

    value: float
    std: float
    origin: str


class FitReport(AnswerModel):
    """A fit and its errors."""

    quantity: str
    strain_gap_pct: float
    resistance_min_ohm: float
    resistance_max_ohm: float
    order: int
    rmse_heating_pct: float
    rmse_cooling_pct: float
    rmse_average_pct: float
    samples: int
    controller: str | None
    no_gains: str | None
    holds: bool
    does_not_hold: str | None
    warnings: Words
    wire_model: dict[str, WireModelNumber] | None


class VarianceShare(AnswerModel):
    """A number that was stated, its standard deviation as a fraction of it, and what it costs of the stroke."""

    name: str
    relative_std: float
    stroke_std: float
    text: str


class HelpfulMeasurement(AnswerModel):
    """A measurement, and the standard deviation of the stroke after it, as a fraction of the stroke."""

    what: str
    stroke_std: float


class FitAnswer(EstimateErrors, FitReport):
    """Of ``fit``; without an instrument of motion how far the model may be off, and what would help."""

    stroke_std_pct: float | None = ABSENT
    misfit: float | None = ABSENT
    costs: tuple[VarianceShare, ...] | None = ABSENT
    helps: tuple[HelpfulMeasurement, ...] | None = ABSENT
    model: str | None


class TuneAnswer(AnswerModel):
    """Of ``tune``."""

    controller: str
    rule: str
    thermal_time_constant_s: float
    dead_time_s: float
    closed_loop_time_s: float
    integral_time_s: float
    smallest_gain_w_per_unit: float
    largest_gain_w_per_unit: float
    gain_margin: float
    phase_margin_deg: float
    delay_margin_s: float
    gains: str | None


class KnownNames(AnswerModel):
    """Names that can be given."""

    known: Words


class RulesAnswer(RuleBase, KnownNames):
    """Of ``rules``: a rule base, and the names of all."""
