"""Observations of a wire, and their residuals against the simulation of a candidate.

An observation simulates a candidate through the recorded history and compares channel by channel, each normalised by
its uncertainty: the noise of the channel, and the error expected of a model of this kind. Noise is white; a model's
error is correlated. It counts once for a stretch of neighbouring points, as if they were one: otherwise the number of
points alone would make intervals too narrow.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.identify._physical.candidates import WireValues


@dataclass(frozen=True, eq=False)
class ObservedChannel:
    """One measured column, (n,), with its standard uncertainty, (n,), both in ``unit``, and the axis it runs over."""

    name: str
    unit: str
    axis_name: str
    axis: FloatArray
    measured: FloatArray
    uncertainty: FloatArray


@dataclass(frozen=True, eq=False)
class ChannelComparison:
    """A channel and its simulation with a candidate, (n,)."""

    channel: ObservedChannel
    predicted: FloatArray

    @property
    def rms(self) -> float:
        """Root mean square of the difference, in the channel's unit."""
        return float(np.sqrt(np.mean((self.predicted - self.channel.measured) ** 2)))

    @property
    def normalised_rms(self) -> float:
        """Root mean square of the difference over the channel's uncertainty."""
        return float(np.sqrt(np.mean(((self.predicted - self.channel.measured) / self.channel.uncertainty) ** 2)))


class Observation(Protocol):
    """A measurement on a wire that can be simulated."""

    @property
    def title(self) -> str:
        """Title in a few words, for people."""
        ...

    @property
    def channels(self) -> Sequence[ObservedChannel]:
        """The channels that are compared."""
        ...

    def refined(self) -> Observation:
        """Return the same observation, simulated with the finest time step."""
        ...

    def simulate(self, values: WireValues) -> Mapping[str, FloatArray]:
        """Return the simulated channels of a wire.

        Parameters
        ----------
        values
            The numbers of the wire on its bench, SI.

        Returns
        -------
        By the channel's name, its values in its unit and on its axis, (n,).

        Raises
        ------
        NumericsError
            If the wire cannot be simulated.
        """
        ...


def compare(observation: Observation, values: WireValues) -> list[ChannelComparison]:
    """Return every channel of an observation with the simulation of a candidate."""
    predicted = observation.simulate(values)
    return [ChannelComparison(channel, predicted[channel.name]) for channel in observation.channels]


def residuals_of(observation: Observation, values: WireValues) -> FloatArray:
    """Return (predicted - measured) / uncertainty of all channels in a row, (n,)."""
    parts = [
        (item.predicted - item.channel.measured) / item.channel.uncertainty for item in compare(observation, values)
    ]
    return np.concatenate(parts)


def binned(values: FloatArray, size: int) -> FloatArray:
    """Return means over groups of ``size`` rows, (n // size,); remaining rows at the end are dropped."""
    count = values.shape[0] // size
    return np.asarray(values[: count * size].reshape(count, size).mean(axis=1))


def with_model_error(noise: FloatArray | float, error: float, points: int, stretches: int) -> FloatArray:
    """Return the uncertainty of each of ``points`` points, (n,), with a model error that counts once for a stretch."""
    together = max(points / stretches, 1.0)
    return np.asarray(np.sqrt(np.square(noise) + error**2 * together) * np.ones(points))
