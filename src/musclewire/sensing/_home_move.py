"""The last home move of a model: when, at which load, what was found, and what may have drifted since."""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite
from typing import ClassVar

from musclewire.errors import CallerError

# Drift of the resistance that is allowed for, as a fraction of its span from B to C.
DRIFT_FRACTION = 0.003
DRIFT_SOURCE = "a wire counts as trained when five cycles move its loop by less than 0.3 % (musclewire train)"
# Besides all standard deviations.
NEVER_NEGATIVE = ("cycles", "load_n", "ambient_k", "drift_resistance_ohm")


@dataclass(frozen=True)
class HomeMove:
    """What one home move found, as the model's file keeps it.

    The resistance of today is ``resistance_scale`` times that of the characterization, plus ``resistance_offset_ohm``;
    both are counted from the characterization, however many home moves came between.

    Parameters
    ----------
    time
        When, in ISO 8601 with the time zone.
    moves
        How many home moves there were since the characterization, this one included.
    cycles
        Cycles that the wire has made since the characterization, if they were counted.
    load_n
        Force of the cold wire that was assumed [N]; None if neither rig nor model states it.
    ambient_k
        Temperature of the air [K], measured; None without a thermometer.
    corrected
        Whether the model's resistances were changed; False if the evidence did not support a correction.
    resistance_scale, resistance_scale_std
        Factor of the resistance, and its standard deviation.
    resistance_offset_ohm, resistance_offset_std_ohm
        Offset of the resistance [ohm], as of longer leads, and its standard deviation [ohm].
    transformation_shift_k, transformation_shift_std_k
        Shift of the transformation temperatures [K], and its standard deviation [K], wide without a thermometer.
    convection_ratio, convection_ratio_std
        Heat loss to the air, over that at the characterization, and its standard deviation.
    drift_resistance_ohm
        Drift of the resistance [ohm] that is allowed for since then, as a standard deviation.
    drift_source
        Why so much.

    Raises
    ------
    CallerError
        For a number that is not finite, or a negative standard deviation or drift.
    """

    # How a model file is checked against these fields.
    __pydantic_config__: ClassVar[dict[str, object]] = {"extra": "forbid", "strict": True}

    time: str
    moves: int
    cycles: float | None
    load_n: float | None
    ambient_k: float | None
    corrected: bool
    resistance_scale: float
    resistance_scale_std: float
    resistance_offset_ohm: float
    resistance_offset_std_ohm: float
    transformation_shift_k: float
    transformation_shift_std_k: float
    convection_ratio: float
    convection_ratio_std: float
    drift_resistance_ohm: float
    drift_source: str = DRIFT_SOURCE

    def __post_init__(self) -> None:
        """Check the numbers."""
        numbers = {name: value for name, value in vars(self).items() if isinstance(value, float)}
        for name, value in numbers.items():
            if not isfinite(value) or (value < 0.0 and ("std" in name or name in NEVER_NEGATIVE)):
                raise CallerError(f"home move: {name} is {value:g}, and must be finite and not negative")
        if not (self.resistance_scale > 0.0 and self.convection_ratio > 0.0 and self.moves >= 1):
            raise CallerError(
                f"home move: scale {self.resistance_scale:g}, convection ratio {self.convection_ratio:g} and number of "
                f"moves {self.moves} must be above 0"
            )
