"""Force from strain and a known spring: the correction of force self-sensing for another load.

The strain of a wire at a resistance hardly depends on the load; its force does, in proportion to the stiffness (Lan and
Fan 2010, Figs. 7 and 8). A model of strain therefore holds for another load, and the law of that load gives the force:
F = k x, with x = S l and the friction of the guide added in the direction of motion.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from musclewire.errors import CallerError
from musclewire.sensing._model import SensingModel
from musclewire.sensing._wire_model import with_wire_model

# Over this travel after a reversal the friction reverses. That of a guide does so within some 20 um, but a
# displacement read from resistance is uncertain by more, and a loop on a force that jumps within it chatters: four
# times the travel of the simulated guide holds on springs from 294 to 1177 N/m (studies/force_self_sensing.py).
TURNING_M = 85e-6


@dataclass(frozen=True)
class KnownSpring:
    """A spring pulled by the wire, and its guide's friction. Raises CallerError for numbers that cannot be."""

    stiffness_n_per_m: float
    friction_n: float = 0.0
    # Travel after a reversal over which friction reverses; four times that of the simulated guide, since a displacement
    # read from resistance is uncertain by more.
    turning_m: float = TURNING_M

    def __post_init__(self) -> None:
        """Check the numbers."""
        if not 0.0 < self.stiffness_n_per_m < float("inf"):
            raise CallerError(f"the load's stiffness is {self.stiffness_n_per_m:g} N/m and must be above 0")
        if not (0.0 <= self.friction_n < float("inf") and self.turning_m > 0.0):
            raise CallerError(
                f"friction of {self.friction_n:g} N over {self.turning_m:g} m: it must be at least 0, the travel above"
            )


def force_model(model: SensingModel, stiffness_n_per_m: float, leg_length_m: float) -> SensingModel:
    """Return a model of the contraction force on a spring [N] from one of strain or of the connector's displacement.

    It has no gains, as a loop takes those of the original model, and no friction, as the average of both branches has
    none. Raises CallerError for a model of force, and for a stiffness or length not above 0.
    """
    if model.quantity == "force":
        raise CallerError(
            "this model senses force already, with the load it was fitted on: give one of strain with a stiffness"
        )
    if not (stiffness_n_per_m > 0.0 and leg_length_m > 0.0):
        raise CallerError(f"stiffness {stiffness_n_per_m:g} N/m and length {leg_length_m:g} m must both be above 0")
    wire = model if model.wire_model else with_wire_model(model)
    per_unit_n = stiffness_n_per_m * (leg_length_m if model.quantity == "strain" else 1.0)

    def scaled(numbers: tuple[float, ...]) -> tuple[float, ...]:
        return tuple(per_unit_n * number for number in numbers)

    return replace(
        model,
        quantity="force",
        heating_coefficients=scaled(model.heating_coefficients),
        cooling_coefficients=scaled(model.cooling_coefficients),
        heating_standard_errors=scaled(model.heating_standard_errors),
        cooling_standard_errors=scaled(model.cooling_standard_errors),
        heating_samples=tuple((ohm, per_unit_n * value) for ohm, value in model.heating_samples),
        cooling_samples=tuple((ohm, per_unit_n * value) for ohm, value in model.cooling_samples),
        rmse_heating=per_unit_n * model.rmse_heating,
        rmse_cooling=per_unit_n * model.rmse_cooling,
        rmse_average=per_unit_n * model.rmse_average,
        offset_std=per_unit_n * model.offset_std,
        measured_stroke=per_unit_n * model.measured_stroke,
        wire={**model.wire, "spring_stiffness_n_per_m": stiffness_n_per_m},
        wire_model=wire.wire_model.per(per_unit_n) if wire.wire_model else None,
        gains={},
        no_gains="those of the model that it was made from are for another quantity",
    )
