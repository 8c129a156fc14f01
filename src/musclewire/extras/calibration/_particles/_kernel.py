"""One sample of the particle filter, compiled: every hypothesis is advanced by the measured power, weighed, renewed.

A bootstrap filter with birth and death of changes: Gordon, Salmond and Smith 1993, doi 10.1049/ip-f-2.1993.0015; which
unknowns a hypothesis changes is drawn, too, as in Green 1995, doi 10.1093/biomet/82.4.711.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.compiled import compiled, compiled_inner
from musclewire.extras.calibration._particles._cloud import CLOCK, HISTORY, ParticleCloud
from musclewire.random_numbers import normal_pair, philox, uniform
from musclewire.wire import Rows, RunningWire, StepConstants, advance_heated

# Places of the unknowns; see settings.UNKNOWNS.
CONVECTION, AMBIENT, LOAD, STIFFNESS, RESISTANCE, TRANSFORMATION = range(6)
N_UNKNOWNS = 6
# A load never takes away more of the pretension than this: the wire would be slack all the time.
MIN_LOAD = -0.9
# Standard deviations: a value further from its mean is put back there.
FURTHEST = 2.0
SECOND_DIFFERENCE = math.sqrt(6.0)  # deviation of a second difference of readings over that of their independent noise
MEAN_TO_DEVIATION = 1.0 / 0.798  # deviation of a normal number over the mean of its absolute value
NOISE_MEMORY = 0.02  # weight of a sample in the mean noise, once there are many
FIRST_SAMPLES = 50.0  # samples that are taken as they are: until then the mean is not known
WILD = 4.0  # times the mean noise: a later sample counts as no more
# Weights are compared by the effective number of hypotheses; below this fraction they are resampled.
RESAMPLE_BELOW = 0.5
# How fast unknowns that have not changed wander within their spread, at each resampling.
RESTLESS = 0.3
# The misfit of the resistance is smoothed over this time.
MISFIT_TIME_S = 0.5
AFRESH = 0.5  # of new hypotheses begin from nothing but one change; the others from those of an old one
ADDED = 0.75  # of new hypotheses have one change more than before, or only that one; the rest have one less
WORTHLESS = -1e9  # logarithm of the weight of a hypothesis that gives no number
SMALLEST = 1e-300  # added to a weight, so that its logarithm has a value
HOPELESS = 3.0  # a restarted hypothesis this far below the mean logarithm of the likelihood is dropped
MOST = 0.1  # weight that one far above it gets at most, until it has proved itself in the samples that follow
# What each change costs a restarted hypothesis in logarithm of likelihood: the simpler of two equal ones is preferred.
COST = 2.0


class ParticleSample(NamedTuple):
    """A sample: power [W], resistance [ohm] (0 if none was read), shunt voltage [V], and the time it took [s]."""

    power_w: float
    resistance_ohm: float
    shunt_voltage_v: float
    duration_s: float


class HypothesisWire(NamedTuple):
    """The calibrated wire: its constants, of which hypotheses change a few, with distribution and load, each (1,)."""

    constants: Rows
    cells: Rows
    load: Rows


class ParticleNumbers(NamedTuple):
    """The numbers of ``ParticleSettings`` that a sample reads; ``spreads`` is its table."""

    spreads: FloatArray
    resistance_error: float
    error_time_s: float
    renewed: float
    renewed_when_lost: float
    lost_misfit: float
    wandering: float
    restarts: int
    seed: int


class SummaryPlaces(NamedTuple):
    """Places of the numbers that a sample answers; those of unknowns and of their changes are rows."""

    contraction: int
    contraction_std: int
    force_n: int
    force_std_n: int
    temperature_k: int
    misfit_ohm: int
    misfit: int
    first_unknown: int
    first_change: int
    evidence: int
    size: int


SUMMARY = SummaryPlaces(0, 1, 2, 3, 4, 5, 6, 7, 13, 19, 20)


@compiled
def follow_sample(
    cloud: ParticleCloud, wire: HypothesisWire, numbers: ParticleNumbers, measured: ParticleSample, answer: FloatArray
) -> None:
    """Advance, weigh and renew all hypotheses by one sample, in place; ``answer`` has the places of ``SUMMARY``."""
    n = cloud.unknowns.shape[0]
    shown = np.empty((4, n))  # resistance, contraction, force, weight
    noise_ohm = noise_of(cloud.clock, measured)
    advance_all(cloud, wire, measured, shown)
    own_ohm = numbers.resistance_error * measured.resistance_ohm
    variance = own_ohm * own_ohm * max(numbers.error_time_s / measured.duration_s, 1.0) + noise_ohm * noise_ohm
    compare(cloud, shown, measured.resistance_ohm, variance)
    evidence = gained(cloud.log_weight)
    effective = weigh(cloud.log_weight, shown[3])
    keep(cloud, measured, variance, shown[3], numbers.seed)
    if cloud.clock[CLOCK.kept] > cloud.history.shape[1] // 4:
        for number in range(numbers.restarts):
            restart(cloud, wire, numbers, shown, number)
    summarise(cloud, shown, answer)
    answer[SUMMARY.evidence] = evidence
    if measured.resistance_ohm > 0.0:
        follow_misfit(cloud.clock, measured, answer, math.hypot(own_ohm, noise_ohm))
    answer[SUMMARY.misfit] = cloud.clock[CLOCK.misfit]
    if effective < RESAMPLE_BELOW * n:
        resample(cloud, shown[3], numbers)
    cloud.clock[CLOCK.samples] += 1.0


@compiled_inner
def compare(cloud: ParticleCloud, shown: FloatArray, resistance_ohm: float, variance_ohm2: float) -> None:
    """Add the likelihood of a measured resistance to that of every hypothesis; 0 ohm stands for no reading."""
    for one in range(cloud.log_weight.shape[0]):
        if not abs(shown[0, one] + shown[1, one] + shown[2, one]) < math.inf:
            cloud.log_weight[one] = WORTHLESS
        elif resistance_ohm > 0.0:
            error_ohm = shown[0, one] - resistance_ohm
            likelihood = -0.5 * error_ohm * error_ohm / variance_ohm2
            cloud.log_weight[one] += likelihood
            cloud.since[0, one] += likelihood
            cloud.since[1, one] += likelihood


@compiled_inner
def gained(log_weight: FloatArray) -> float:
    """Return the logarithm of the mean likelihood of a sample: how well the hypotheses foresaw it."""
    highest = log_weight.max()
    return float(highest + math.log(np.exp(log_weight - highest).sum()))


@compiled_inner
def noise_of(clock: FloatArray, measured: ParticleSample) -> float:
    """Return the noise of a sample's resistance [ohm], from second differences of those before: the drive is smooth.

    What is followed is the noise of a voltage, since one at the sense voltage is that of one under drive.
    """
    resistance_ohm = measured.resistance_ohm
    if not resistance_ohm > 0.0:
        return 0.0
    if clock[CLOCK.last_but_one_ohm] > 0.0:
        bend_ohm = abs(resistance_ohm - 2.0 * clock[CLOCK.last_ohm] + clock[CLOCK.last_but_one_ohm])
        noise_v = bend_ohm / SECOND_DIFFERENCE * MEAN_TO_DEVIATION * measured.shunt_voltage_v
        before_v = clock[CLOCK.noise_v]
        memory = max(NOISE_MEMORY, 1.0 / max(clock[CLOCK.samples] - 1.0, 1.0))
        if clock[CLOCK.samples] > FIRST_SAMPLES:
            noise_v = min(noise_v, WILD * before_v)
        clock[CLOCK.noise_v] = before_v + memory * (noise_v - before_v)
    clock[CLOCK.last_but_one_ohm], clock[CLOCK.last_ohm] = clock[CLOCK.last_ohm], resistance_ohm
    return float(clock[CLOCK.noise_v] / measured.shunt_voltage_v)


class VariedConstants(NamedTuple):
    """The constants of the calibrated wire that hypotheses change."""

    ambient_k: float
    surface_m2: float
    pretension_n: float
    spring_n: float
    martensite_k: float
    r_phase_k: float


@compiled_inner
def calibrated_of(k: StepConstants) -> VariedConstants:
    """Return the constants that hypotheses change."""
    return VariedConstants(
        k.ambient_temperature_k,
        k.surface_factor_m2,
        k.pretension_n,
        k.spring_n,
        k.martensite_temperature_k,
        k.r_phase_temperature_k,
    )


@compiled_inner
def set_hypothesis(k: StepConstants, known: VariedConstants, unknown: FloatArray) -> None:
    """Set the constants to those of a hypothesis."""
    k.ambient_temperature_k = known.ambient_k + unknown[AMBIENT]
    k.surface_factor_m2 = known.surface_m2 * math.exp(unknown[CONVECTION])
    k.pretension_n = known.pretension_n * (1.0 + unknown[LOAD])
    k.spring_n = known.spring_n * math.exp(unknown[STIFFNESS])
    k.martensite_temperature_k = known.martensite_k + unknown[TRANSFORMATION]
    k.r_phase_temperature_k = known.r_phase_k + unknown[TRANSFORMATION]


@compiled_inner
def advance_all(cloud: ParticleCloud, wire: HypothesisWire, measured: ParticleSample, shown: FloatArray) -> None:
    """Advance the wire of every hypothesis; ``shown`` gets its resistance [ohm], contraction and force [N]."""
    k, cells, load = wire.constants[0], wire.cells[0], wire.load[0]
    known = calibrated_of(k)
    for one in range(cloud.unknowns.shape[0]):
        set_hypothesis(k, known, cloud.unknowns[one])
        running = RunningWire(cloud.wires[one], k, cells, load)
        resistance_ohm, contraction, force_n = advance_heated(running, measured.power_w, measured.duration_s)
        shown[0, one] = resistance_ohm * math.exp(cloud.unknowns[one, RESISTANCE])
        shown[1, one], shown[2, one] = contraction, force_n
    set_hypothesis(k, known, np.zeros(N_UNKNOWNS))


@compiled_inner
def weigh(log_weight: FloatArray, weight: FloatArray) -> float:
    """Fill in the weights, which add up to 1, and return the effective number of hypotheses."""
    log_weight -= log_weight.max()
    weight[:] = np.exp(log_weight)
    total = weight.sum()
    weight /= total
    log_weight -= math.log(total)
    return float(1.0 / (weight * weight).sum())


@compiled_inner
def summarise(cloud: ParticleCloud, shown: FloatArray, answer: FloatArray) -> None:
    """Fill in weighted means and deviations; hypotheses that could not be computed have no weight."""
    answer[:] = 0.0
    total_ohm = 0.0
    for one in range(shown.shape[1]):
        weight = shown[3, one]
        if weight == 0.0:
            continue
        total_ohm += weight * shown[0, one]
        answer[SUMMARY.contraction] += weight * shown[1, one]
        answer[SUMMARY.force_n] += weight * shown[2, one]
        answer[SUMMARY.temperature_k] += weight * cloud.wires[one].temperature_k
        for place in range(N_UNKNOWNS):
            answer[SUMMARY.first_unknown + place] += weight * cloud.unknowns[one, place]
            answer[SUMMARY.first_change + place] += weight * cloud.changed[one, place]
    answer[SUMMARY.misfit_ohm] = total_ohm
    for one in range(shown.shape[1]):
        weight = shown[3, one]
        if weight > 0.0:
            answer[SUMMARY.contraction_std] += weight * (shown[1, one] - answer[SUMMARY.contraction]) ** 2
            answer[SUMMARY.force_std_n] += weight * (shown[2, one] - answer[SUMMARY.force_n]) ** 2
    answer[SUMMARY.contraction_std] = math.sqrt(answer[SUMMARY.contraction_std])
    answer[SUMMARY.force_std_n] = math.sqrt(answer[SUMMARY.force_std_n])


@compiled_inner
def follow_misfit(clock: FloatArray, measured: ParticleSample, answer: FloatArray, explained_ohm: float) -> None:
    """Turn the mean resistance into its misfit, and smooth that in units of what wire and noise explain."""
    answer[SUMMARY.misfit_ohm] -= measured.resistance_ohm
    part = min(measured.duration_s / MISFIT_TIME_S, 1.0)
    clock[CLOCK.misfit] += part * (answer[SUMMARY.misfit_ohm] / explained_ohm - clock[CLOCK.misfit])


@compiled_inner
def keep(cloud: ParticleCloud, measured: ParticleSample, variance_ohm2: float, weight: FloatArray, seed: int) -> None:
    """Keep a sample for restarts; from time to time the newer snapshot becomes the older one, and another is taken."""
    place, length = int(cloud.clock[CLOCK.kept]), cloud.history.shape[1]
    half = length // 2
    if place == half and cloud.clock[CLOCK.samples] == half:
        snapshot(cloud, weight, seed)
    if place == length:
        cloud.history[:, :half] = cloud.history[:, half:].copy()
        cloud.old[:] = cloud.new
        cloud.since[0] = cloud.since[1]
        snapshot(cloud, weight, seed)
        place = half
    cloud.history[HISTORY.power_w, place] = measured.power_w
    cloud.history[HISTORY.duration_s, place] = measured.duration_s
    cloud.history[HISTORY.resistance_ohm, place] = measured.resistance_ohm
    cloud.history[HISTORY.variance_ohm2, place] = variance_ohm2
    cloud.clock[CLOCK.kept] = place + 1.0


@compiled_inner
def snapshot(cloud: ParticleCloud, weight: FloatArray, seed: int) -> None:
    """Take a snapshot of the wires, drawn by their weights, from which the likelihood counts from 0."""
    samples = int(cloud.clock[CLOCK.samples])
    for one in range(cloud.new.shape[0]):
        word, _, _, _ = philox(samples, one, 4, 0, seed)
        cloud.new[one] = cloud.wires[drawn(weight, uniform(word))]
    cloud.since[1, :] = 0.0


@compiled_inner
def drawn(weight: FloatArray, chance: float) -> int:
    """Return the index of a hypothesis drawn by weight."""
    reached = 0.0
    for one in range(weight.shape[0]):
        reached += weight[one]
        if chance < reached:
            return one
    return int(weight.shape[0]) - 1


@compiled_inner
def restart(
    cloud: ParticleCloud, wire: HypothesisWire, numbers: ParticleNumbers, shown: FloatArray, number: int
) -> None:
    """Try a new hypothesis from the older snapshot on; if it explains the samples since, it replaces the worst one."""
    weight, samples = shown[3], int(cloud.clock[CLOCK.samples])
    a, b, c, d = philox(samples, number, 5, 0, numbers.seed)
    parent = drawn(weight, uniform(a))
    unknown, changed = cloud.unknowns[parent].copy(), cloud.changed[parent].copy()
    deviates = six_deviates(samples, cloud.unknowns.shape[0] + number, numbers.seed)
    change(unknown, changed, numbers, deviates, (uniform(b), uniform(c)))
    unknown[LOAD] = max(unknown[LOAD], MIN_LOAD)
    first = min(int(uniform(d) * cloud.old.shape[0]), cloud.old.shape[0] - 1)
    tried = cloud.old[first : first + 1].copy()
    present = simpler = 0.0
    for one in range(weight.shape[0]):
        present += weight[one] * cloud.since[0, one]
        simpler += weight[one] * COST * cloud.changed[one].sum()
    present -= simpler - COST * changed.sum()
    likelihood, seen = follow_history(cloud, wire, unknown, tried, present - HOPELESS)
    if not likelihood > present - HOPELESS:
        return
    worst = int(np.argmin(weight))
    given = min(math.exp(min(likelihood - present, HOPELESS)) / weight.shape[0], MOST)
    weight *= (1.0 - given) / (1.0 - weight[worst])
    weight[worst] = given
    cloud.log_weight[:] = np.log(weight + SMALLEST)
    cloud.wires[worst] = tried[0]
    cloud.unknowns[worst], cloud.changed[worst] = unknown, changed
    cloud.since[0, worst] = cloud.since[1, worst] = likelihood
    shown[0, worst], shown[1, worst], shown[2, worst] = seen


@compiled_inner
def follow_history(
    cloud: ParticleCloud, wire: HypothesisWire, unknown: FloatArray, tried: Rows, least: float
) -> tuple[float, tuple[float, float, float]]:
    """Run a wire through the kept samples; return likelihood, and what it shows; end early below ``least``."""
    k, cells, load = wire.constants[0], wire.cells[0], wire.load[0]
    known = calibrated_of(k)
    set_hypothesis(k, known, unknown)
    running = RunningWire(tried[0], k, cells, load)
    likelihood, seen = 0.0, (0.0, 0.0, 0.0)
    for place in range(int(cloud.clock[CLOCK.kept])):
        sample = cloud.history[:, place]
        resistance_ohm, contraction, force_n = advance_heated(
            running, sample[HISTORY.power_w], sample[HISTORY.duration_s]
        )
        resistance_ohm *= math.exp(unknown[RESISTANCE])
        seen = (resistance_ohm, contraction, force_n)
        if sample[HISTORY.resistance_ohm] > 0.0:
            error_ohm = resistance_ohm - sample[HISTORY.resistance_ohm]
            likelihood -= 0.5 * error_ohm * error_ohm / sample[HISTORY.variance_ohm2]
        if not likelihood > least:
            break
    set_hypothesis(k, known, np.zeros(N_UNKNOWNS))
    return likelihood, seen


@compiled_inner
def resample(cloud: ParticleCloud, weight: FloatArray, numbers: ParticleNumbers) -> None:
    """Draw the hypotheses again by their weights; some are renewed, all others wander a little.

    Systematic resampling: Kitagawa 1996, doi 10.2307/1390750.
    """
    n = weight.shape[0]
    wires, unknowns, changed = cloud.wires.copy(), cloud.unknowns.copy(), cloud.changed.copy()
    since = cloud.since.copy()
    samples = int(cloud.clock[CLOCK.samples])
    first, _, _, _ = philox(samples, n, 0, 0, numbers.seed)
    offset, parent, reached = uniform(first) / n, 0, weight[0]
    lost = abs(cloud.clock[CLOCK.misfit]) > numbers.lost_misfit
    renewed = numbers.renewed_when_lost if lost else numbers.renewed
    for one in range(n):
        while offset + one / n > reached and parent < n - 1:
            parent += 1
            reached += weight[parent]
        cloud.wires[one] = wires[parent]
        cloud.unknowns[one] = unknowns[parent]
        cloud.changed[one] = changed[parent]
        cloud.since[:, one] = since[:, parent]
        cloud.log_weight[one] = -math.log(n)
        words = philox(samples, one, 1, 0, numbers.seed)
        deviates = six_deviates(samples, one, numbers.seed)
        if uniform(words[0]) < renewed:
            change(cloud.unknowns[one], cloud.changed[one], numbers, deviates, (uniform(words[1]), uniform(words[2])))
        else:
            wander(cloud.unknowns[one], cloud.changed[one], numbers, deviates)
        cloud.unknowns[one, LOAD] = max(cloud.unknowns[one, LOAD], MIN_LOAD)


@compiled_inner
def six_deviates(samples: int, one: int, seed: int) -> tuple[float, float, float, float, float, float]:
    """Return six independent normal numbers of a hypothesis at a sample."""
    a, b, c, d = philox(samples, one, 2, 0, seed)
    e, f, _, _ = philox(samples, one, 3, 0, seed)
    return *normal_pair(a, b), *normal_pair(c, d), *normal_pair(e, f)


@compiled_inner
def change(
    unknown: FloatArray,
    changed: FloatArray,
    numbers: ParticleNumbers,
    deviates: tuple[float, float, float, float, float, float],
    chances: tuple[float, float],
) -> None:
    """Make another hypothesis of one: a single change instead of its own, one more, or one less."""
    place, below = N_UNKNOWNS - 1, 0.0
    for candidate in range(N_UNKNOWNS):
        below += numbers.spreads[2, candidate]
        if chances[0] < below:
            place = candidate
            break
    afresh = chances[1] < AFRESH
    for other in range(N_UNKNOWNS):
        if afresh:
            changed[other] = 0.0
            unknown[other] = deviates[other] * numbers.spreads[1, other]
    changed[place] = 1.0 if chances[1] < ADDED else 0.0
    unknown[place] = deviates[place] * numbers.spreads[0 if changed[place] == 1.0 else 1, place]


@compiled_inner
def wander(
    unknown: FloatArray,
    changed: FloatArray,
    numbers: ParticleNumbers,
    deviates: tuple[float, float, float, float, float, float],
) -> None:
    """Move a hypothesis a little: what has changed by a random walk, what has not within its spread at rest."""
    for place in range(N_UNKNOWNS):
        spread = numbers.spreads[0 if changed[place] == 1.0 else 1, place]
        step = numbers.wandering if changed[place] == 1.0 else RESTLESS
        # A walk with this pull towards 0 leaves the distribution that the unknown was drawn from as it is.
        moved = (1.0 - 0.5 * step * step) * unknown[place] + step * spread * deviates[place]
        unknown[place] = min(max(moved, -FURTHEST * spread), FURTHEST * spread)
