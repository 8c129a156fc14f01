"""The wires of a search: the parameters to be fitted as a vector, and the wire that a vector describes."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.errors import CallerError, NumericsError
from musclewire.parameters import Alloy, Bench, Prior, PriorSet, Wire
from musclewire.wire import SHAPE, ConnectorLoad, OffsetDistribution, WireConstants, constants_of, measured_grains


class WireValues(NamedTuple):
    """The bare numbers of a wire on a bench, by name, in SI; and its grains, if they were measured."""

    alloy: dict[str, float]
    wire: dict[str, float]
    bench: dict[str, float]
    grains: OffsetDistribution | None = None


class CandidateParameters:
    """Parameters to find, as vectors of standard normal coordinates: 0 is the prior's mean, 1 its deviation.

    There is one coordinate for each of ``names``; all other numbers keep the value of the given wire, alloy and bench.
    """

    def __init__(self, priors: PriorSet, alloy: Alloy, wire: Wire, bench: Bench, only: list[str] | None = None) -> None:
        """Take the priors, or those of them in ``only``; measured quantiles of the grains leave their shape known."""
        known = SHAPE if alloy.grain_quantiles is not None else ()
        chosen = {
            name: prior
            for name, prior in priors.parameters.items()
            if (only is None or name in only) and name not in known
        }
        self.names: tuple[str, ...] = tuple(chosen)
        self.priors: tuple[Prior, ...] = tuple(chosen.values())
        self._base = WireValues(alloy.values(), wire.values(), bench.values(), measured_grains(alloy))
        self._mean = np.array([prior.mean for prior in self.priors])
        self._std = np.array([prior.std for prior in self.priors])
        self.low: FloatArray = (np.array([prior.low for prior in self.priors]) - self._mean) / self._std
        self.high: FloatArray = (np.array([prior.high for prior in self.priors]) - self._mean) / self._std

    def __len__(self) -> int:
        """Return the number of unknown parameters."""
        return len(self.names)

    def numbers(self, coordinates: FloatArray) -> FloatArray:
        """Return parameters in SI from coordinates, both (n_parameters,)."""
        return np.asarray(self._mean + self._std * coordinates)

    def coordinates(self, numbers: FloatArray) -> FloatArray:
        """Return coordinates from parameters in SI, both (n_parameters,)."""
        return np.asarray((numbers - self._mean) / self._std)

    def wire_values(self, coordinates: FloatArray) -> WireValues:
        """Return the wire that a vector describes."""
        values = WireValues(dict(self._base.alloy), dict(self._base.wire), dict(self._base.bench), self._base.grains)
        for name, prior, number in zip(self.names, self.priors, self.numbers(coordinates), strict=True):
            getattr(values, prior.group)[name] = float(number)
        return values

    def start(self, number: int, drawn: FloatArray) -> FloatArray:
        """Return the coordinates of a search's start by its number: drawn, but for what has starts of its own."""
        found = drawn.copy()
        for place, prior in enumerate(self.priors):
            if prior.starts:
                found[place] = (prior.starts[number % len(prior.starts)] - prior.mean) / prior.std
        return found

    def draw(self, random: np.random.Generator) -> FloatArray:
        """Return coordinates drawn from the prior, truncated at the bounds, (n_parameters,)."""
        found = np.empty(len(self))
        for index in range(len(self)):
            while True:
                found[index] = random.standard_normal()
                if self.low[index] < found[index] < self.high[index]:
                    break
        return found


def candidate_constants(
    values: WireValues, spool: Mapping[str, float], bench: Mapping[str, float], load: ConnectorLoad | None = None
) -> WireConstants:
    """Return the constants of a candidate's alloy on a spool and a bench, which an observation may know better.

    Raises NumericsError if its numbers cannot be a wire's, as spreads with which the phases have no order, which a
    prior's limits allow for each number alone. A search passes such candidates over.
    """
    try:
        return constants_of(values.alloy, spool, bench, load=load, distribution=values.grains)
    except CallerError as error:
        raise NumericsError(f"a candidate cannot be a wire: {error}") from error
