"""Force at a known load: the estimate of strain, through the spring's stiffness, against the load cell."""

from __future__ import annotations

import numpy as np

from musclewire.errors import MusclewireError
from musclewire.extras.studies._robustness.characterising import UsersKnowledge
from musclewire.extras.studies._robustness.estimating import estimated
from musclewire.extras.studies._robustness.recorded_run import RecordedRun
from musclewire.extras.studies._robustness.scoring import ErrorSums, judged_from_s, usable
from musclewire.extras.studies._robustness.settings import Condition, RunSettings
from musclewire.sensing import KnownSpring, force_model
from musclewire.wire import WireConstants

# Cold samples whose mean is the load cell's zero.
ZERO_SAMPLES = 4


def force_score(
    run: RecordedRun,
    estimator: str,
    condition: Condition,
    knowledge: UsersKnowledge,
    times: RunSettings,
    wire: WireConstants | None,
) -> ErrorSums:
    """Return the score of an estimator's force against the load cell, in forces of the spring at the full stroke.

    Parameters
    ----------
    run
        The run.
    estimator
        Name of the estimator.
    condition
        Its condition; where it changes the load, the user does not know: the force that he assumes is the old one's.
    knowledge
        What the wire's user knows, the stiffness that his rig states included.
    times
        Times of a run.
    wire
        Constants of the user's wire file.

    Returns
    -------
    Sums; without samples if the estimator has no force.
    """
    stiffness = float(knowledge.loop.metadata["spring_stiffness_n_per_m"] or 0.0)
    leg_m = run.facts["leg_length_m"]
    full_n = stiffness * leg_m * knowledge.stroke
    friction_n = float(knowledge.model.wire.get("guide_friction_n", 0.0))
    try:
        model = force_model(knowledge.model, stiffness, leg_m)
        found = estimated(run, model, estimator, wire, KnownSpring(stiffness, friction_n))
    except MusclewireError:
        return ErrorSums()
    judged = usable(run.strain, knowledge, times) & (run.time_s >= judged_from_s(condition, times))
    measured = run.force_n - run.force_n[:ZERO_SAMPLES].mean()
    error = (found.value - measured)[judged] / full_n
    valid = found.valid[judged]
    return ErrorSums(
        samples=int(judged.sum()),
        squares=float(error @ error),
        valid=int(valid.sum()),
        wrong=int(np.sum(valid & (np.abs(error) > 0.05))),
    )
