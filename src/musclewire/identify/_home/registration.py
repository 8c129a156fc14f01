"""Laying a sweep over the loop that a model was fitted to: scale, offset, shift of temperatures, air; with uncertainty.

Resistance against warming is a curve with a shape: the rise to B, the fall, the way back. Two of its axes may have
moved: resistance by a factor (ageing), an offset (leads) and, through the temperature at which the wire transforms, by
the temperature coefficient of martensite; warming by the air's temperature, the shift of the transformation, and the
loss to the air. The search is for all of them at once, with what is known beforehand about each as its prior, so that
what the sweep cannot separate stays uncertain.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from musclewire.arrays import FloatArray
from musclewire.identify._home.warming import STEPS_PER_LAG, HeatCourse, WarmingBranches, WireHeat, branches_of

# What is known beforehand, as standard deviations: ageing of a trained wire within a percent, joints and leads within
# half an ohm; the transformation moves by some kelvins, or by 12 where the load has changed by half, which must show;
# air of a room; a factor of the loss by ten percent, or by much more in a draught (so the tails are heavy); heat
# capacity and latent heat (10 to 20 kJ/kg, published_ranges) as for any NiTi wire.
SCALE_STD, OFFSET_STD_OHM, SHIFT_STD_K, AIR_STD_K = 0.007, 0.3, 8.0, 8.0
AIR_KNOWN_STD_K = 2.0
LOG_RATIO_STD, LOG_LAG_STD, LOG_LATENT_STD = 0.05, 0.15, 0.3
LATENT_K = 20.0
# Resistivity of martensite rises by this fraction per kelvin, that of austenite by a fifth of it or less (Churchill and
# Shaw, SMASIS2009-48968: about 0.5e-3 and 0.1e-3 per kelvin).
MARTENSITE_PER_K = 0.5e-3
# The curve's own error, as a fraction of its span, and the error of the warming [K]. A faster sweep does not transform
# quite as far as the loop did, so that C says least; B does not depend on how fast it is passed.
CURVE_FRACTION, WARMING_STD_K = 0.05, 0.7
# Neighbouring samples share their errors: so many count as one.
TOGETHER = 20.0
# A reading at no current has no resistance; noise of the voltage over it is this for a converter of 16 bits.
MIN_CURRENT_A = 1e-3


class RegistrationUnknowns(NamedTuple):
    """What lays a sweep over a loop, or a standard deviation of each.

    Parameters
    ----------
    scale, offset_ohm
        Today's resistance is the loop's times ``scale``, and ``offset_ohm`` more [ohm].
    shift_k
        Shift of the transformation [K].
    air_k
        Change of the air's temperature [K].
    log_ratio, log_lag, log_latent
        Logarithms of loss, lag and latent heat over their prior means.
    """

    scale: float
    offset_ohm: float
    shift_k: float
    air_k: float
    log_ratio: float
    log_lag: float
    log_latent: float


NAMES = RegistrationUnknowns._fields


class AnchorPoint(NamedTuple):
    """A point of the curve that both loop and sweep show, as B: resistances [ohm], and the error between them [ohm]."""

    loop_ohm: float
    sweep_ohm: float
    std_ohm: float


class Registration(NamedTuple):
    """What lays a sweep over a loop.

    Parameters
    ----------
    values
        The unknowns as found.
    stds
        Their standard deviations.
    covariance
        Their covariance, (7, 7).
    misfit_ohm
        Root mean square of what is left [ohm].
    moved_ohm
        Change of the resistance at C and at B [ohm].
    moved_stds_ohm
        Standard deviations of these changes [ohm].
    """

    values: RegistrationUnknowns
    stds: RegistrationUnknowns
    covariance: FloatArray
    misfit_ohm: float
    moved_ohm: tuple[float, float]
    moved_stds_ohm: tuple[float, float]


class RegistrationProblem:
    """The residuals of a sweep against a loop."""

    def __init__(
        self,
        loop: HeatCourse,
        sweep: HeatCourse,
        heat: WireHeat,
        ends_ohm: tuple[float, float],
        anchors: tuple[AnchorPoint, ...],
        air_k: float | None,
    ) -> None:
        """Resample both; ``ends_ohm`` are the model's resistances at C and B, ``air_k`` the air's known change."""
        step_s = heat.lag_s / STEPS_PER_LAG
        self.loop, self.sweep, self.heat = loop.evenly(step_s), sweep.evenly(step_s / 2.0), heat
        self.low_ohm, self.high_ohm = ends_ohm
        self.span_ohm = self.high_ohm - self.low_ohm
        self.anchors = anchors
        self.air_k, self.air_std_k = (0.0, AIR_STD_K) if air_k is None else (air_k, AIR_KNOWN_STD_K)
        self.noise_ohm = reading_noise_ohm(sweep, self.sweep)
        self.start = np.array([1.0, 0.0, 0.0, self.air_k, 0.0, 0.0, 0.0])

    def mapped(self, values: FloatArray, resistance_ohm: FloatArray | float) -> FloatArray | float:
        """Return today's resistance [ohm] for one of the loop's."""
        unknowns = unknowns_of(values)
        colder = (resistance_ohm - self.low_ohm) / self.span_ohm  # 1 at B, all martensite, and 0 at C
        drifted_ohm = resistance_ohm + MARTENSITE_PER_K * self.high_ohm * unknowns.shift_k * colder
        return unknowns.scale * drifted_ohm + unknowns.offset_ohm

    def change_ohm(self, values: FloatArray, at_ohm: float) -> float:
        """Return by how much a resistance of the loop has changed [ohm]."""
        return float(self.mapped(values, at_ohm)) - at_ohm

    def branches(self, values: FloatArray) -> WarmingBranches:
        """Return the loop's branches for a lag and a latent heat."""
        lag_s, latent = self.heat.lag_s * float(np.exp(unknowns_of(values).log_lag)), self.latent(values)
        return branches_of(self.loop, self.loop.warming_k(self.heat, lag_s, latent))

    def latent(self, values: FloatArray) -> float:
        """Return the latent heat as kelvins of warming per ohm."""
        return LATENT_K / self.span_ohm * float(np.exp(unknowns_of(values).log_latent))

    def difference(self, values: FloatArray) -> tuple[FloatArray, FloatArray, NDArray[np.bool_]]:
        """Return what the sweep reads over the curve [ohm], its standard deviation [ohm], and where both exist."""
        branches = self.branches(values)
        unknowns = unknowns_of(values)
        lag_s, ratio = self.heat.lag_s * float(np.exp(unknowns.log_lag)), float(np.exp(unknowns.log_ratio))
        warming = self.sweep.warming_k(self.heat, lag_s, self.latent(values), ratio)
        warming = warming + (unknowns.air_k - unknowns.shift_k)
        expected, inside = branches.along_course(warming, int(np.argmax(warming)))
        steps = np.maximum(np.abs(np.gradient(warming)), 1e-3)
        slope = np.minimum(np.abs(np.gradient(expected)) / steps, self.span_ohm / 5.0)
        std = np.sqrt(self.noise_ohm**2 + (CURVE_FRACTION * self.span_ohm) ** 2 + (WARMING_STD_K * slope) ** 2)
        mapped = np.asarray(self.mapped(values, expected))
        return self.sweep.resistance_ohm - mapped, std, np.asarray(inside, dtype=np.bool_)

    def residuals(self, values: FloatArray) -> FloatArray:
        """Return residuals of samples, anchors and priors, each over its standard deviation."""
        left, std, inside = self.difference(values)
        samples = np.where(inside, left / std, 0.0) / np.sqrt(TOGETHER)
        points = [(one.sweep_ohm - float(self.mapped(values, one.loop_ohm))) / one.std_ohm for one in self.anchors]
        unknowns = unknowns_of(values)
        heavy = np.sign(unknowns.log_ratio) * np.sqrt(np.log1p((unknowns.log_ratio / LOG_RATIO_STD) ** 2))
        prior = [
            (unknowns.scale - 1.0) / SCALE_STD,
            unknowns.offset_ohm / OFFSET_STD_OHM,
            unknowns.shift_k / SHIFT_STD_K,
            (unknowns.air_k - self.air_k) / self.air_std_k,
            heavy,
            unknowns.log_lag / LOG_LAG_STD,
            unknowns.log_latent / LOG_LATENT_STD,
        ]
        return np.concatenate([samples, points, prior])


def unknowns_of(values: FloatArray) -> RegistrationUnknowns:
    """Return the numbers of a search by their names."""
    return RegistrationUnknowns(*values.tolist())


def reading_noise_ohm(measured: HeatCourse, grid: HeatCourse) -> FloatArray:
    """Return the noise of the resistance on a grid [ohm]: that of a voltage, found in the samples, over the current."""
    from musclewire.sensing import noise_level

    current = np.sqrt(np.maximum(measured.power_w / measured.resistance_ohm, MIN_CURRENT_A**2))
    noise_v = noise_level(measured.resistance_ohm * current) if measured.time_s.size > 1 else 0.0
    on_grid = np.sqrt(np.maximum(grid.power_w / grid.resistance_ohm, MIN_CURRENT_A**2))
    return np.asarray(noise_v / on_grid)


def register(
    loop: HeatCourse,
    sweep: HeatCourse,
    heat: WireHeat,
    ends_ohm: tuple[float, float],
    anchors: tuple[AnchorPoint, ...] = (),
    air_k: float | None = None,
) -> Registration:
    """Lay a sweep over a loop by least squares.

    Parameters
    ----------
    loop
        The loop that the model was fitted to.
    sweep
        The sweep of today.
    heat
        Heat capacity and loss of the wire.
    ends_ohm
        Resistance of the model at C and at B [ohm].
    anchors
        Points that both show.
    air_k
        Measured change of the air's temperature between them [K]; None if it is unknown.

    Returns
    -------
    Scale, offset, shift and the rest, with their uncertainty.
    """
    from scipy.optimize import least_squares

    problem = RegistrationProblem(loop, sweep, heat, ends_ohm, anchors, air_k)
    scales = [0.01, 0.1, 3.0, 3.0, 0.1, 0.1, 0.2]
    searches = [least_squares(problem.residuals, start, x_scale=scales) for start in starts(problem)]
    found = min(searches, key=lambda one: float(one.cost))
    left, _, inside = problem.difference(found.x)
    covariance = covariance_of(np.asarray(found.jac, dtype=np.float64), np.array(scales))
    low_ohm, high_ohm = ends_ohm
    return Registration(
        values=unknowns_of(found.x),
        stds=unknowns_of(np.sqrt(np.diag(covariance))),
        covariance=covariance,
        misfit_ohm=float(np.sqrt(np.mean(left[inside] ** 2))) if inside.any() else float("inf"),
        moved_ohm=(problem.change_ohm(found.x, low_ohm), problem.change_ohm(found.x, high_ohm)),
        moved_stds_ohm=(
            moved_std_ohm(problem, found.x, covariance, low_ohm),
            moved_std_ohm(problem, found.x, covariance, high_ohm),
        ),
    )


def starts(problem: RegistrationProblem) -> list[FloatArray]:
    """Return where to begin the search: as characterized, and with the loss by which the hottest samples agree."""
    ratio = float(problem.sweep.power_w.max() / problem.loop.power_w.max())
    other = problem.start.copy()
    other[NAMES.index("log_ratio")] = np.log(min(max(ratio, 0.2), 5.0))
    return [problem.start, other]


def covariance_of(slopes: FloatArray, scales: FloatArray) -> FloatArray:
    """Return the covariance of unknowns from the slopes of residuals, (n_residuals, n), without squaring them first."""
    _, sizes, directions = np.linalg.svd(slopes * scales, full_matrices=False)
    spread = directions.T / np.maximum(sizes, 1e-9 * sizes[0])
    own = scales[:, None] * spread
    return np.asarray(own @ own.T)


def moved_std_ohm(problem: RegistrationProblem, values: FloatArray, covariance: FloatArray, at_ohm: float) -> float:
    """Return the standard deviation of the change of a resistance [ohm]."""
    slope = np.zeros(values.size)
    for place, step in enumerate((1e-4, 1e-3, 1e-2)):
        stepped = values.copy()
        stepped[place] += step
        slope[place] = (problem.change_ohm(stepped, at_ohm) - problem.change_ohm(values, at_ohm)) / step
    return float(np.sqrt(slope @ covariance @ slope))
