"""The staircase for a model of any quantity: the paper's shape within the model's range."""

from __future__ import annotations

import math

from musclewire.controllers import Staircase, staircase
from musclewire.errors import CallerError
from musclewire.sensing import SHOWN_AS, SensingModel

# The paper's staircase goes to 3.0 % where its wire reaches 3.6 %, from half of that, in five steps.
TOP_FRACTION = 0.84
STEPS = 5
DIGITS = 2


def staircase_within(model: SensingModel) -> Staircase:
    """Return the paper's staircase for strain; for displacement and force, from half of a round top in five steps.

    The top is 84 % of the model's maximum, rounded down to two digits. Raises CallerError if half of it is below the
    model's minimum.
    """
    if model.quantity == "strain":
        return staircase()
    top = TOP_FRACTION * model.quantity_max
    unit = 10.0 ** (math.floor(math.log10(top)) - DIGITS + 1)
    top = unit * math.floor(top / unit)
    if 0.5 * top < model.quantity_min:
        factor, name = SHOWN_AS[model.quantity]
        raise CallerError(
            f"no staircase fits: its first step would be {factor * 0.5 * top:.4g} {name}, and the model senses "
            f"{model.quantity} from {factor * model.quantity_min:.4g} {name}: give a reference of your own"
        )
    return staircase(0.5 * top, top, 0.5 * top / STEPS)
