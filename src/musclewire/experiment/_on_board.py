"""The closed loop on the board: the host sends targets, the firmware senses, controls and protects, the host records.

The loop is the same as on the host, in C, with the numbers the firmware was built with. By its checksum a board shows
which loop of a model it runs; one that was built for another model is refused. What corrects the model is decided here.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from math import isfinite
from typing import NamedTuple, Unpack

from musclewire.controllers import FeedforwardSettings, FuzzyPidSettings, Reference
from musclewire.errors import CallerError, RigError
from musclewire.experiment._closed_loop import FACTOR, LoopChoice, PreparedLoop, prepared_loop
from musclewire.experiment._cooling import cooling_after
from musclewire.experiment._metrics import ControlRun, with_metrics
from musclewire.experiment._run import Decision, RunOptions, run_on_rig
from musclewire.experiment._speed_limits import speed_metadata
from musclewire.identify import gains_of, settings_for
from musclewire.judge import KEPT
from musclewire.rigs import HasOnBoardLoop, Rig, ability
from musclewire.sensing import PAPER_ESTIMATOR, SensingModel, state_going_on
from musclewire.signals import COLUMN_SUFFIX, Command, RawSample, Target, wire_sample


class TargetPolicy:
    """Sends the reference's targets and records the board's estimates; it controls nothing.

    A board does not say how certain an estimate is: its estimator says so here, by the same readings.
    """

    def __init__(self, board: HasOnBoardLoop, loop: PreparedLoop, sample_period_s: float) -> None:
        """Begin with the reference's first target, which the approach holds, and send the board what is known."""
        self._board, self._loop, self._sample_period_s = board, loop, sample_period_s
        self._estimator, self._correction = loop.estimator, loop.correction_of()
        self._state = self._estimator.start()
        board.correct(self._correction.correction if loop.corrects else None)

    @property
    def columns(self) -> Sequence[str]:
        """Names of the columns this policy adds."""
        suffix = COLUMN_SUFFIX[self._loop.model.quantity]
        more = (*((FACTOR,) if self._loop.corrects else ()), *(("announced_miss",) if self._loop.fastest else ()))
        return ("wire_resistance_ohm", f"target_{suffix}", f"estimated_{suffix}", "estimate_std", "valid", *more)

    def first_command(self) -> Command:
        """Return the first target."""
        return self._target_at(0.0)

    def after(self, sample: RawSample, elapsed_s: float) -> Decision:
        """Return the next target, with the board's estimate of the last sample. Raises RigError if either fails."""
        taken_s, since_s = elapsed_s - self._sample_period_s, elapsed_s - self._loop.approach_s
        read = wire_sample(sample)._replace(time_s=elapsed_s)
        own, self._state, _ = self._estimator.step(self._state, read)
        if own.failure:
            raise RigError(own.failure)
        reported = self._board.board_estimate
        if own.valid and reported is not None and isfinite(reported):
            own = own._replace(value=reported)
        factor = (self._correction.correction.scale,) if self._loop.corrects else ()
        estimate = self._correction.shown(own)
        if self._correction.watch(read, own, taken_s):
            self._board.correct(self._correction.correction)
            self._estimator = self._loop.estimator_of(self._correction.correction)
            self._state = state_going_on(self._estimator, self._state)
        followed = self._loop.reference.target_at(max(since_s - self._sample_period_s, 0.0))
        announced = () if self._loop.fastest is None else (self._loop.fastest.miss(followed),)
        seen = (followed, estimate.value, estimate.std, float(estimate.valid))
        recorded = (self._board.board_resistance_ohm or 0.0, *seen, *factor, *announced)
        return Decision(self._target_at(max(since_s, 0.0)), recorded)

    def _target_at(self, time_s: float) -> Target:
        """Return the reference's target at a time, in the quantity of the board's model."""
        return Target(self._loop.reference.target_at(time_s), self._loop.model.quantity)


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
    zero_from: str = KEPT,
    known_strain: float | tuple[float, float] | None = None,
    **run: Unpack[RunOptions],
) -> ControlRun:
    """Let a board's firmware, which was built with the same model and settings, move the wire along a reference.

    The estimate recorded is the board's; where the model is corrected, as in ``control``, the board gets the
    correction. Raises CallerError for a rig without a board, a board that was built for another model or controller, or
    a target outside the model's range, and RigError for a board whose firmware knows no corrections, if one may be
    needed.
    """
    board = ability(rig, HasOnBoardLoop)
    if board is None:
        raise CallerError("only a board with musclewire's firmware closes the loop itself: this rig has none")
    if isinstance(settings, FuzzyPidSettings):
        settings = settings_for(model, settings)
    runs = loop_of_board(board, model, settings, rig.sample_period_s)
    choice = LoopChoice(*runs, settings, approach_s=approach_s, zero_from=zero_from, known_strain=known_strain)
    loop = prepared_loop(rig, model, reference, choice)
    beforehand = {"experiment": "closed loop on the board", **speed_metadata(rig, model, loop.reference, None)}
    policy = TargetPolicy(board, loop, rig.sample_period_s)
    following = cooling_after(rig, policy.columns, loop.cooling_s)
    metadata = loop.metadata | beforehand
    recording = run_on_rig(rig, policy, loop.duration_s, metadata=metadata, following=following, **run)
    return with_metrics(recording, model.quantity, loop.reference)
