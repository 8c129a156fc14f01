"""The report of a fit in addition to its curve: errors, samples, warnings, the wire and the source."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from math import hypot
from statistics import median

from musclewire.sensing._curve import Pairs, ResistanceCurve, require_in_range
from musclewire.sensing._home_move import DRIFT_FRACTION, HomeMove
from musclewire.sensing._wire_tables import WireModel

Rows = tuple[tuple[float, float, float], ...]
GainValue = str | float | tuple[float, ...]


@dataclass(frozen=True)
class FittedCurve(ResistanceCurve):
    """A resistance curve and the report of the fit that found it: data, and nothing that writes or draws.

    Parameters
    ----------
    hysteresis_gap
        Distance of the branches over their largest quantity, Eq. 2 (Eq. 9 for displacement), a fraction.
    rmse_average
        Root mean square error of the average against the samples of both branches, in the quantity's unit.
    samples
        Samples of the recording that the fit used.
    heating_standard_errors, cooling_standard_errors
        Standard errors of the coefficients; empty if they are unknown.
    warnings
        Doubts about the fit, one sentence each.
    wire
        Notes on the wire and its rig by name: "wire", "wire_length_m", for example.
    created_by, source
        Program and recording the curve comes from.
    heating_samples, cooling_samples
        Some pairs of resistance [ohm] and quantity for a figure; none by default.
    slow_loop
        Time [s], electrical power [W] and resistance [ohm] through the loop, from cold to hot and back, with which a
        home move compares; none if the recording has no power.
    home
        The last home move; None if there was none since the characterization.
    gains
        "controller", the name of the one that a loop with this model takes by default, and that one's settings by name;
        empty if none were found. Here they are only kept: ``musclewire.controllers.Gains`` reads them.
    no_gains
        Why the fit found no gains; "" if it found them, or did not look.
    measured_stroke
        Largest less cold quantity of the loop, in its unit, as it was measured; 0 if no motion was.
    wire_model
        What the loop shows of the wire besides the curve; None if it does not go from cold to hot and back, and for a
        model that was made without a loop.
    converted
        Of a model that is not as its file has it: what was made of an older one, in a sentence; "" otherwise.
    does_not_hold
        Why a closed loop by this model is wrong, as the fit's own recording shows; "" if it shows nothing of the kind.

    Raises
    ------
    CallerError
        If the parts contradict each other.
    """

    hysteresis_gap: float = 0.0
    rmse_average: float = 0.0
    samples: int = 0
    heating_standard_errors: tuple[float, ...] = ()
    cooling_standard_errors: tuple[float, ...] = ()
    warnings: tuple[str, ...] = ()
    wire: Mapping[str, str | float] = field(default_factory=dict, hash=False)
    created_by: str = "musclewire"
    source: str = ""
    heating_samples: Pairs = field(default=(), repr=False)
    cooling_samples: Pairs = field(default=(), repr=False)
    slow_loop: Rows = field(default=(), repr=False)
    home: HomeMove | None = None
    gains: Mapping[str, GainValue] = field(default_factory=dict, hash=False, repr=False)
    no_gains: str = ""
    measured_stroke: float = 0.0
    does_not_hold: str = ""
    wire_model: WireModel | None = field(default=None, repr=False)
    converted: str = field(default="", compare=False, repr=False)

    def __post_init__(self) -> None:
        """Check the curve and the report."""
        super().__post_init__()
        require_in_range((self.hysteresis_gap, self.rmse_average, self.samples, self.measured_stroke))

    @property
    def strain_gap(self) -> float:
        """The hysteresis gap of Eq. 2 (or Eq. 9 for displacement), a fraction."""
        return self.hysteresis_gap

    @property
    def holds(self) -> bool:
        """Whether nothing is known against a closed loop by this model."""
        return not self.does_not_hold

    @property
    def stroke(self) -> float:
        """What errors are a percentage of: the measured stroke or, where no motion was measured, the model's range."""
        return self.measured_stroke or self.quantity_max - self.quantity_min

    @property
    def drift_resistance_ohm(self) -> float:
        """Drift of the resistance [ohm] since the last home move, or since the fit, as a standard deviation."""
        if self.home is not None:
            return self.home.drift_resistance_ohm
        return DRIFT_FRACTION * (self.resistance_max_ohm - self.resistance_min_ohm)

    @property
    def cold_resistance_ohm(self) -> float:
        """Resistance [ohm] of the cold wire at the beginning of the slow loop; that of B without a loop."""
        heating_ohm = [row[2] for row in self.slow_loop[: self._hottest_row + 1]]
        if not heating_ohm:
            return self.resistance_max_ohm
        # Half of the rows before B are those of the cold wire; the smallest of them would be that of the noise.
        return median(heating_ohm[: heating_ohm.index(max(heating_ohm)) // 2 + 1])

    @property
    def b_power_w(self) -> float:
        """Power [W] at which the slow loop, while it heated, had its highest resistance; 0 without a loop."""
        heating = self.slow_loop[: self._hottest_row + 1]
        return max(heating, key=lambda row: row[2])[1] if heating else 0.0

    @property
    def _hottest_row(self) -> int:
        """Row of the slow loop with the smallest resistance."""
        return min(range(len(self.slow_loop)), key=lambda row: self.slow_loop[row][2], default=0)

    def curve(self) -> ResistanceCurve:
        """Return the curve alone: the few numbers that an estimator uses."""
        numbers = {one.name: getattr(self, one.name) for one in fields(ResistanceCurve) if one.init}
        if self.home is not None:
            # What may have drifted since the last home move is in every standard deviation.
            per_ohm = (self.quantity_max - self.quantity_min) / (self.resistance_max_ohm - self.resistance_min_ohm)
            numbers["offset_std"] = hypot(self.offset_std, per_ohm * self.drift_resistance_ohm)
        return ResistanceCurve(**numbers)
