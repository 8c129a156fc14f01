"""The gated estimator: Eq. 1, then the branch of the direction in which the wire is driven (``_gated_branches``).

Samples without current are bridged, another wire's resistance is detected, and on a known spring the guide's
friction is added, all as the paper's estimator does. In contrast to it a reading that no wire of this model can have,
as a contact that jumps gives it, leaves the estimate as it is; and a wire that has cooled beyond B again is cold again.
"""

from __future__ import annotations

from musclewire.compiled import callback
from musclewire.sensing._curve import ResistanceCurve
from musclewire.sensing._curve_estimator import N_ARRAYS, CurveEstimator, estimator_numbers
from musclewire.sensing._estimator import EstimatorSetup
from musclewire.sensing._gated_branches import GATED_NUMBERS, GATES, GatedState, gated_tick
from musclewire.sensing._known_load import KnownSpring
from musclewire.sensing._polynomial_estimator import polynomial_tick
from musclewire.signals import CompiledTick


class GatedEstimator(CurveEstimator):
    """Estimates by the branch of the direction in which electrical power drives the wire.

    Parameters
    ----------
    curve
        The wire's resistance curve. One whose two branches are equal gives a filtered polynomial.
    shunt_resistance_ohm
        R [ohm] of Eq. 1.
    sample_period_s
        Time [s] between two samples.
    load
        A known spring, if the curve is one of the force on it; its friction is added in the direction of motion.
    """

    def __init__(
        self,
        curve: ResistanceCurve,
        shunt_resistance_ohm: float,
        sample_period_s: float,
        load: KnownSpring | None = None,
    ) -> None:
        """Take the numbers; the state of a run is not kept here."""
        numbers = estimator_numbers(curve, shunt_resistance_ohm, load) | gated_numbers(curve)
        numbers["dt_s"] = sample_period_s
        first_state = GatedState(curve.quantity_min, numbers["load_friction_n"])
        super().__init__(curve, gated_tick, [numbers[name] for name in GATED_NUMBERS], first_state)

    def compiled_tick(self) -> CompiledTick:
        """Return the tick that ``step`` runs."""
        return self._tick


def gated_numbers(curve: ResistanceCurve) -> dict[str, float]:
    """Return the numbers of the gated branches that follow from a curve, by name.

    Parameters
    ----------
    curve
        The wire's resistance curve.

    Returns
    -------
    In the curve's quantity or its variance: how far beyond the branches the quantity may be, and the least variance of
    an estimate; and the variance of the first resistance, normalised.
    """
    span = curve.quantity_max - curve.quantity_min
    noise = curve.resistance_noise_ohm * curve.numbers["per_ohm"]
    return {
        "beyond": GATES.beyond * span,
        "min_variance": curve.numbers["residual_variance"] + GATES.range_variance * span * span,
        "first_variance": noise * noise,
    }


def gated_estimator(setup: EstimatorSetup) -> GatedEstimator:
    """Return the estimator by direction-gated branches for a loop.

    Parameters
    ----------
    setup
        Model, shunt, sample period, and the known spring if force is estimated.

    Returns
    -------
    The estimator.
    """
    return GatedEstimator(setup.model.curve(), setup.shunt_resistance_ohm, setup.sample_period_s, setup.load)


def compile_estimators() -> None:
    """Compile the ticks of the estimators on a curve, for a program that makes them later, with a rig switched on."""
    for tick in (gated_tick, polynomial_tick):
        callback(tick, N_ARRAYS)
