"""The closed loop on the board: the host sends targets, the firmware senses, controls and protects, the host records.

The loop is the same as on the host, in C, with the numbers the firmware was built with. By its checksum a board shows
which loop of a model it runs; one that was built for another model is refused.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from typing import NamedTuple, Unpack

from musclewire.controllers import FeedforwardSettings, FuzzyPidSettings, Reference
from musclewire.errors import CallerError
from musclewire.experiment._calm_air import heed_air
from musclewire.experiment._closed_loop import APPROACH_S
from musclewire.experiment._metrics import ControlRun, with_metrics
from musclewire.experiment._run import Decision, RunOptions, run_on_rig
from musclewire.experiment._speed_limits import check_targets, fastest_way, followed, speed_metadata
from musclewire.identify import FastestWay, check_made_for, gains_of, load_facts, settings_for
from musclewire.rigs import HasOnBoardLoop, Rig, ability
from musclewire.sensing import PAPER_ESTIMATOR, SensingModel
from musclewire.signals import COLUMN_SUFFIX, Command, RawSample, Target


class TargetPolicy:
    """Sends the reference's targets and records the board's estimates; it controls nothing."""

    def __init__(
        self,
        loop: HasOnBoardLoop,
        model: SensingModel,
        reference: Reference,
        *,
        sample_period_s: float,
        approach_s: float,
        fastest: FastestWay | None,
    ) -> None:
        """Begin with the reference's first target, which the approach holds."""
        self._loop, self._model, self._reference = loop, model, reference
        self._sample_period_s, self._approach_s, self._fastest = sample_period_s, approach_s, fastest
        model.estimate(model.resistance_max_ohm)  # compiled here, and not in the first sample
        suffix = COLUMN_SUFFIX[model.quantity]
        self._target_name, self._estimated_name = f"target_{suffix}", f"estimated_{suffix}"

    @property
    def columns(self) -> Sequence[str]:
        """Names of the columns this policy adds."""
        announced = () if self._fastest is None else ("announced_miss",)
        return ("wire_resistance_ohm", self._target_name, self._estimated_name, "valid", *announced)

    def first_command(self) -> Command:
        """Return the first target."""
        return self._target_at(0.0)

    def after(self, _sample: RawSample, elapsed_s: float) -> Decision:
        """Return the next target, with the board's estimate of the sample that has just ended."""
        since_s = elapsed_s - self._approach_s
        judged = self._reference.target_at(max(since_s - self._sample_period_s, 0.0))
        resistance_ohm = self._loop.board_resistance_ohm or 0.0
        estimate = self._loop.board_estimate
        valid = resistance_ohm > 0.0 and self._model.estimate(resistance_ohm).valid
        return Decision(
            self._target_at(max(since_s, 0.0)),
            (
                resistance_ohm,
                judged,
                estimate if estimate is not None and valid else self._model.quantity_min,
                float(valid),
                *(() if self._fastest is None else (self._fastest.miss(judged),)),
            ),
        )

    def _target_at(self, time_s: float) -> Target:
        """Return the reference's target at a time, in the quantity of the board's model."""
        return Target(self._reference.target_at(time_s), self._model.quantity)


# What firmware is built with: estimators, and controllers by the kind of their settings.
ESTIMATORS_ON_BOARDS = ("filter", PAPER_ESTIMATOR)
Settings = FuzzyPidSettings | FeedforwardSettings


class LoopOnBoard(NamedTuple):
    """Names of the estimator and the controller that a board runs."""

    estimator: str
    controller: str


def loop_of_board(
    board: HasOnBoardLoop, model: SensingModel, settings: Settings | None, sample_period_s: float
) -> LoopOnBoard:
    """Return which of a model's loops a board runs: the one by whose numbers it has its checksum.

    Without ``settings`` it may be by the model's gains or by the fuzzy PID's own. Raises CallerError if it is none.
    """
    gains = gains_of(model, sample_period_s)
    known: list[Settings] = [] if gains is None else [gains.settings]
    for tried in [*known, settings_for(model)] if settings is None else [settings]:
        for estimator in ESTIMATORS_ON_BOARDS:
            with suppress(CallerError):  # a model without a slow loop has no filter
                if board.checksum_of(model, tried, estimator) == board.model_checksum:
                    fuzzy = isinstance(tried, FuzzyPidSettings)
                    return LoopOnBoard(estimator, "fuzzy-pid" if fuzzy else "inverse-model")
    raise CallerError(
        f"the board's firmware was built for another model or controller (checksum {board.model_checksum:08x}, "
        "which no loop of this model has): build it with this model (firmware/build.py --model) and flash it"
    )


def control_on_board(
    rig: Rig,
    model: SensingModel,
    reference: Reference | None = None,
    *,
    settings: Settings | None = None,
    approach_s: float | None = None,
    **run: Unpack[RunOptions],
) -> ControlRun:
    """Let a board's firmware move the wire along a reference.

    Parameters
    ----------
    rig
        A board with musclewire's firmware, open.
    model
        The model that the firmware was built with.
    reference
        Targets in the model's quantity; if None the paper's staircase within the model's range.
    settings
        Settings of the controller that the firmware was built with; by default the model's gains, or those of the fuzzy
        PID for the model's quantity.
    approach_s
        Time [s] for which the reference's start is held before the reference begins; by default none, 12 s for the
        fuzzy PID.
    **run
        ``path`` of the recording, ``overwrite`` one that exists, ``on_sample`` called with every recorded row; it
        may raise to stop the run, ``until`` asked after each whether the run is to end now.

    Returns
    -------
    The recording with its metrics, the estimate being the board's.

    Raises
    ------
    CallerError
        For a rig without a board, a board that was built for another model or controller, or a target outside the
        model's range.
    """
    loop = ability(rig, HasOnBoardLoop)
    if loop is None:
        raise CallerError("only a board with musclewire's firmware closes the loop itself: this rig has none")
    if isinstance(settings, FuzzyPidSettings):
        settings = settings_for(model, settings)
    runs = loop_of_board(loop, model, settings, rig.sample_period_s)
    if approach_s is None:
        approach_s = APPROACH_S if runs.controller == "fuzzy-pid" else 0.0
    chosen = followed(model, reference)
    check_targets(model, chosen, rig.sample_period_s)
    check_made_for(model, rig.metadata())
    heed_air(rig, model)
    recording = run_on_rig(
        rig,
        TargetPolicy(
            loop,
            model,
            chosen,
            sample_period_s=rig.sample_period_s,
            approach_s=approach_s,
            fastest=fastest_way(rig, model, None, from_cold=approach_s == 0.0),
        ),
        approach_s + chosen.duration_s,
        metadata={
            "experiment": "closed loop on the board",
            "quantity": model.quantity,
            **runs._asdict(),
            **load_facts(model, rig.metadata()),
            "approach_s": approach_s,
            **speed_metadata(rig, model, chosen, None),
        },
        **run,
    )
    return with_metrics(recording, model.quantity, chosen)
