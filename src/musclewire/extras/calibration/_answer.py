"""What calibrate prints with --json."""

from __future__ import annotations

from typing import Annotated

from musclewire.app import AnswerModel, AnswerRecord
from musclewire.extras.calibration._physical.posterior import ParameterEstimate

Words = tuple[str, ...]
CalibratedParameter = Annotated[
    ParameterEstimate,
    AnswerRecord(without=("name", "low", "high", "measure"), identifiable=bool, at_bound=bool),
]


class CalibratedChannel(AnswerModel):
    """How well the fitted wire follows one channel of a recording."""

    recording: str
    channel: str
    unit: str
    rms: float
    rms_in_uncertainties: float


class CorrelatedParameters(AnswerModel):
    """Two parameters that are identified together rather than apart."""

    parameters: tuple[str, str]
    r: float


class AdvisedExperiment(AnswerModel):
    """What to measure next."""

    title: str
    text: str
    tells: Words
    narrows: Words


class CalibrateAnswer(AnswerModel):
    """Of ``calibrate``."""

    parameters: dict[str, CalibratedParameter]
    not_identifiable: Words
    rmse: float
    holds: bool
    channels: tuple[CalibratedChannel, ...]
    correlated: tuple[CorrelatedParameters, ...]
    not_searched: Words
    notes: Words
    excess_variance: float
    simulations: int
    descent_costs: tuple[float, ...]
    wall_s: float
    seed: int
    advice: tuple[AdvisedExperiment, ...]
    recordings: Words
    started_from: str
    priors: str
    wire: str | None
    report: str | None
    warnings: Words
