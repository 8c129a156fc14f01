"""What an estimator is: a sample of the wire in, state in; estimate with standard deviation, validity and reason out.

An estimator has no clock, reads no reference instrument and keeps nothing to itself: its only memory is its state,
which the loop passes back. ``tests/contract/test_estimator_contract.py`` tests every implementation for this. One that
also declares ``compiled_tick()``, a :class:`~musclewire.signals.CompiledTick` of its step with the state of ``start``,
can run in compiled loops (``mw.control_many``).

Another estimator is one file with a factory, an ``EstimatorFactory``, and a name for it: a line in ``ESTIMATORS`` here,
or from outside ``ESTIMATORS.register("name", factory)`` in a script and ``estimators`` in a package's manifest. One
that needs physics may use published equations (``physics``) with constants from the user's own wire file, never the
simulator.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import Any, Protocol

from musclewire.registry import Registry
from musclewire.sensing._correction import UNCORRECTED, Correction
from musclewire.sensing._fit_report import FittedCurve
from musclewire.sensing._known_load import KnownSpring
from musclewire.signals import EstimatorStep, QuantityEstimate, RawSample, WireSample, check_columns
from musclewire.wire import WireConstants

# A sample without current is bridged by holding the drive; this many in a row are a broken wire or circuit.
MAX_DROPOUTS = 10


class Estimator(Protocol):
    """Estimates strain, displacement or force of a wire from its own voltages, sample by sample."""

    @property
    def quantity(self) -> str:
        """Estimated quantity: "strain", "displacement" or "force"."""
        ...

    @property
    def columns(self) -> tuple[str, ...]:
        """Names of the columns that it records, one for each number in ``EstimatorStep.recorded``."""
        ...

    @property
    def has_c_form(self) -> bool:
        """Whether ``musclewire export c`` writes it, so that a board can run it."""
        ...

    def start(self) -> Any:
        """Return the state before the first sample: an immutable value that only this estimator reads."""
        ...

    def step(self, state: Any, sample: WireSample) -> EstimatorStep:
        """Return the estimate of one sample.

        Pure: the same arguments give the same answer, and the state is not changed. Value and standard deviation are
        always finite; without current the value is the last one.

        Parameters
        ----------
        state
            The state that ``start`` or the last ``step`` returned.
        sample
            The measured voltages of the wire, with time and drive.

        Returns
        -------
        Estimate, next state, and the numbers to record.
        """
        ...


@dataclass(frozen=True)
class EstimatorSetup:
    """All that a factory may make an estimator from.

    Parameters
    ----------
    model
        The fitted curve of the wire; for a quantity of "force" already that of the force.
    shunt_resistance_ohm
        R [ohm] of Eq. 1.
    sample_period_s
        Time [s] between two samples.
    load
        The spring that the wire pulls, if force is estimated from a model of strain; its friction belongs to the force.
    wire
        Constants of the user's wire file on the load of the rig, for an estimator on physics; None without a file.
    correction
        How the wire of today differs from the characterized one. It is in the model, and not in the wire file.
    """

    model: FittedCurve
    shunt_resistance_ohm: float
    sample_period_s: float
    load: KnownSpring | None = None
    wire: WireConstants | None = None
    correction: Correction = UNCORRECTED


def state_going_on(estimator: Estimator, before: Any) -> Any:
    """Return the state by which an estimator of a corrected model goes on after one of the model before.

    As at the start, because what it has followed was another resistance; but one that does not find a warm wire from
    its start says by a method ``going_on`` what of the state holds.
    """
    own = getattr(estimator, "going_on", None)
    return estimator.start() if own is None else own(before)


EstimatorFactory = Callable[[EstimatorSetup], Estimator]

ESTIMATORS: Registry[EstimatorFactory] = Registry(
    "estimator",
    "estimators",
    {
        "polynomial": "musclewire.sensing._polynomial_estimator:polynomial_estimator",
        "filter": "musclewire.sensing._filter_estimator:filter_estimator",
    },
    parts=("quantity", "columns", "start", "step"),
    check=check_columns,
)


def dropout_failure(
    dropouts: int, sample: WireSample | RawSample, allowed: int = MAX_DROPOUTS, pulls: str = "wire"
) -> str:
    """Return why a run must end after so many samples in a row without current; "" while they are bridged.

    The default bridges half a second at the paper's 50 ms. ``pulls`` is "wires" if several share the circuit.
    """
    if dropouts < allowed:
        return ""
    return (
        f"no current through the {pulls} for {dropouts} samples up to {sample.time_s:.2f} s at "
        f"{sample.drive_voltage_v:.2f} V: check {pulls}, clamps and shunt; the rig is at its sense voltage"
    )


def estimates(
    estimator: Estimator, samples: Iterable[WireSample]
) -> Iterator[tuple[QuantityEstimate, tuple[float, ...]]]:
    """Yield each sample's estimate, from the estimator's start on, and the numbers that the estimator records."""
    state = estimator.start()
    for sample in samples:
        estimate, state, recorded = estimator.step(state, sample)
        yield estimate, recorded
