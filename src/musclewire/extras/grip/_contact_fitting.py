"""Fits to closings of a gripper: the reference for contact from free closings, the force curve from known grips."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import nnls

from musclewire.arrays import FloatArray
from musclewire.errors import RecordingError
from musclewire.extras.grip._contact_detection import AirDisturbance, ContactDetector, FreeClosing
from musclewire.extras.grip._grip_force import GripCurve
from musclewire.judge import resistance_reading
from musclewire.parameters import load_alloy
from musclewire.signals import Recording
from musclewire.wire import HeatBalance

# Between these normalised resistances the slope is steep enough to locate a closing. Below, the grains that transform
# last take much heat for little resistance: with 0.08 free closings of the wire 'finger-100um' raise alarms there,
# in 15 of 20 draughty runs, and with 0.2 in none.
NORMALISED_RANGE = (0.2, 0.95)
# Orders of polynomials over the normalised resistance:
HOLDING_ORDER = 3  # of the power that holds a wire
ENERGY_ORDER = 2  # of the energy that a change takes
# Power and motion are compared over blocks of this many samples: single differences of resistance are mostly noise.
BLOCK_SAMPLES = 5
MIN_BLOCKS = 30
CURVE_ORDER = 7  # of a finger's endpoint
LEVERAGE_ORDER = 5  # of its leverage
COST_ORDER = 1  # of the power per newton
# Forces below this are too near the load cell's noise to learn compliances from.
MIN_FORCE_N = 0.05
MIN_FORCE_SAMPLES = 12
# The power per newton, as the detector computes it, is fitted up to this force: half more than the usual grip. It
# changes in the course of a closing, and the grip is decided within the first samples after contact.
MAX_COST_FORCE_N = 0.45
# The thermal time constant is that at a wall temperature near the transformation under load, in air of a room.
WALL_K = 363.15
AIR_K = 295.15
NOISE_SEARCH = (1e-4, 3e-2)
SEARCH_STEPS = 30


@dataclass(frozen=True)
class KnownGrip:
    """A closing on a block of known stiffness with a load cell between the fingers.

    Parameters
    ----------
    recording
        The closing, with ``endpoint_force_n``.
    stiffness_n_per_m
        Stiffness of the block [N/m].
    """

    recording: Recording
    stiffness_n_per_m: float


@dataclass(frozen=True)
class GripperClosing:
    """A closing from the beginning of contraction: normalised resistance and power [W], (n,), and their rows."""

    normalised: FloatArray
    power_w: FloatArray
    dt_s: float
    rows: slice


def thermal_time_s(diameter_m: float, alloy: str = "flexinol") -> float:
    """Return a wire's thermal time constant by convection [s]: rho c d / (4 h), with h of Churchill and Chu."""
    return HeatBalance.of_wire(load_alloy(alloy), diameter_m, 1.0, AIR_K).with_loss_at(WALL_K).lag_s


def electrical(recording: Recording) -> tuple[FloatArray, FloatArray]:
    """Return resistance [ohm] and power [W] of the wires, (n_times,); NaN for samples without current."""
    reading = resistance_reading(recording)
    resistance = np.where(reading.valid, reading.resistance_ohm, np.nan)
    return resistance, recording["wire_voltage_v"] ** 2 / resistance


def fit_free_closing(recordings: Sequence[Recording], alloy: str = "flexinol") -> FreeClosing:
    """Fit the power of closing without an object: theta and m of P = theta(l) - m(l) dl/dt, and the noise.

    The recordings are closings at different speeds, which separate theta from m; a dozen of them average over the air's
    motion. The fit is by least squares on blocks of samples, each relative to its power. The noise is the smallest for
    which the detector's innovations on these closings are no larger than it expects.

    Parameters
    ----------
    recordings
        The closings.
    alloy
        Name or wire file; its density and specific heat give the thermal time constant.

    Returns
    -------
    The reference for contact.

    Raises
    ------
    RecordingError
        If the recordings hold no closing, too few, or speeds that differ too little.
    """
    low_ohm, high_ohm = resistance_range(recordings)
    blocks = [block for one in recordings for block in blocks_of(closing_of(one, low_ohm, high_ohm))]
    if len(blocks) < MIN_BLOCKS:
        raise RecordingError(
            f"{len(recordings)} free closings give {len(blocks)} blocks of {BLOCK_SAMPLES} samples, and {MIN_BLOCKS} "
            "are needed: record more closings, at different speeds, that close fully"
        )
    holding, energy = power_terms(blocks)
    free = FreeClosing(
        resistance_min_ohm=low_ohm,
        resistance_max_ohm=high_ohm,
        holding_power_w=tuple(map(float, holding)),
        closing_energy_j=tuple(map(float, energy)),
        normalised_min=NORMALISED_RANGE[0],
        normalised_max=NORMALISED_RANGE[1],
        normalised_noise=NOISE_SEARCH[1],
        thermal_time_s=thermal_time_s(recordings[0].facts.wire_diameter_m, alloy),
    )
    return replace(free, normalised_noise=noise_of(free, recordings))


def power_terms(blocks: Sequence[tuple[float, float, float]]) -> tuple[FloatArray, FloatArray]:
    """Return polynomials of holding power [W] and energy of motion [J]. Raises RecordingError if one is negative."""
    place, rate_per_s, power_w = np.array(blocks).T
    basis = np.hstack(
        [np.vander(place, HOLDING_ORDER + 1, increasing=True),
         -rate_per_s[:, None] * np.vander(place, ENERGY_ORDER + 1, increasing=True)]
    )  # fmt: skip
    found = np.linalg.lstsq(basis / power_w[:, None], np.ones_like(power_w), rcond=None)[0]
    holding, energy = found[: HOLDING_ORDER + 1], found[HOLDING_ORDER + 1 :]
    across = np.linspace(*NORMALISED_RANGE, 50)
    if min(np.polyval(holding[::-1], across).min(), np.polyval(energy[::-1], across).min()) <= 0.0:
        raise RecordingError(
            "holding power and energy of motion cannot be separated in these closings, one is negative: record them "
            "at speeds that differ more"
        )
    return holding, energy


def resistance_range(recordings: Sequence[Recording]) -> tuple[float, float]:
    """Return the minimum and maximum resistance of closings [ohm], of means over three samples to reduce noise."""
    lows, highs = [], []
    for one in recordings:
        resistance, power_w = electrical(one)
        # At low current resistance is mostly noise.
        sure = resistance[power_w > 0.1 * np.nanmax(power_w)]
        if sure.size < BLOCK_SAMPLES:
            raise RecordingError(
                f"a closing has {sure.size} samples with power, {BLOCK_SAMPLES} are needed: drive the wire"
            )
        smoothed = np.convolve(sure, np.full(3, 1.0 / 3.0), mode="valid")
        lows.append(smoothed.min())
        highs.append(smoothed.max())
    return float(np.median(lows)), float(np.median(highs))


def closing_of(recording: Recording, low_ohm: float, high_ohm: float) -> GripperClosing:
    """Return the part of a recording in which the wire contracts, within the usable range."""
    resistance, power_w = electrical(recording)
    normalised = (resistance - low_ohm) / (high_ohm - low_ohm)
    top = int(np.nanargmax(np.where(power_w > 0.1 * np.nanmax(power_w), normalised, -np.inf)))
    low, high = NORMALISED_RANGE
    begin = top + int(np.argmax(normalised[top:] < high))
    over = normalised[begin:] < low
    end = begin + int(np.argmax(over)) if over.any() else begin + int(np.nanargmin(normalised[begin:]))
    dt_s = recording.facts.sample_period_s
    return GripperClosing(normalised[begin:end], power_w[begin:end], dt_s, slice(begin, end))


def blocks_of(closing: GripperClosing) -> list[tuple[float, float, float]]:
    """Return mean normalised resistance, its rate [1/s] and mean power [W] of each block of a closing."""
    found = []
    for first in range(0, closing.normalised.size - BLOCK_SAMPLES, BLOCK_SAMPLES):
        place, power = (column[first : first + BLOCK_SAMPLES + 1] for column in (closing.normalised, closing.power_w))
        rate = (place[-1] - place[0]) / (BLOCK_SAMPLES * closing.dt_s)
        found.append((trapezoid_mean(place), float(rate), trapezoid_mean(power)))
    return [block for block in found if block[1] < 0.0]


def trapezoid_mean(values: FloatArray) -> float:
    """Return the mean over time of equally spaced values by the trapezoidal rule."""
    return float((values.sum() - 0.5 * (values[0] + values[-1])) / (values.size - 1))


def noise_of(free: FreeClosing, recordings: Sequence[Recording]) -> float:
    """Return the smallest noise of normalised resistance for which innovations are no larger than expected."""
    low, high = NOISE_SEARCH
    selected = [closing_of(one, free.resistance_min_ohm, free.resistance_max_ohm) for one in recordings]
    for _ in range(SEARCH_STEPS):
        middle = float(np.sqrt(low * high))
        surprises = [
            surprise for one in selected for surprise in surprises_of(replace(free, normalised_noise=middle), one)
        ]
        low, high = (middle, high) if np.mean(np.square(surprises)) > 1.0 else (low, middle)
    return high


def surprises_of(free: FreeClosing, closing: GripperClosing) -> list[float]:
    """Return the detector's normalised innovations over a closing."""
    detector, found = ContactDetector(free, AirDisturbance()), []
    state = detector.start()._replace(highest=1.0)
    span = free.resistance_max_ohm - free.resistance_min_ohm
    for place, power_w in zip(closing.normalised, closing.power_w, strict=True):
        after = detector.step(state, free.resistance_min_ohm + span * float(place), float(power_w), closing.dt_s)
        if after.following and after.innovation is not None:
            found.append(after.innovation)
        state = after
    return found


def fit_grip_curve(
    free_recordings: Sequence[Recording], known: Sequence[KnownGrip], free: FreeClosing, *, fingers: int
) -> GripCurve:
    """Fit closing, compliances and power per force of the fingers to closings with instruments.

    Free closings, with ``displacement_m`` and ``endpoint_displacement_m``, give the endpoint over resistance. Grips of
    blocks of known stiffness, with ``endpoint_force_n``, give the compliances of finger and wire and the power per
    newton, with contact as the detector finds it.

    Parameters
    ----------
    free_recordings
        Closings without an object.
    known
        Closings on blocks of known stiffness.
    free
        The reference for contact.
    fingers
        How many fingers touch the object, 1 or 2.

    Returns
    -------
    The curve for force.

    Raises
    ------
    RecordingError
        If a column is missing, or too few samples carry force.
    """
    for one in (*free_recordings, *(item.recording for item in known)):
        for name in ("displacement_m", "endpoint_displacement_m"):
            if name not in one:
                raise RecordingError(f"grip force is fitted to closings with instruments: one lacks {name}, record it")
    curve = rigid_curve(free_recordings, free, fingers)
    grips = [grip_samples(one, free) for one in known]
    finger, wire = compliances(curve, grips)
    return replace(
        curve,
        finger_compliance_m_per_n=finger,
        wire_compliance_m_per_n=wire,
        power_per_newton_w=power_per_newton_w(curve, grips),
    )


def rigid_curve(free_recordings: Sequence[Recording], free: FreeClosing, fingers: int) -> GripCurve:
    """Return the fingers' closing over resistance, with compliances of 0 and 1 W/N as placeholders for their fits."""
    places, connector, endpoint = (np.concatenate(column) for column in zip(
        *(columns_of(one, free) for one in free_recordings), strict=True))  # fmt: skip
    endpoint_over_place = np.polynomial.Polynomial.fit(places, endpoint, CURVE_ORDER).convert()
    endpoint_over_connector = np.polynomial.Polynomial.fit(connector, endpoint, CURVE_ORDER)
    lever = endpoint_over_connector.deriv()(connector)
    lever_over_place = np.polynomial.Polynomial.fit(places, lever, LEVERAGE_ORDER).convert()
    return GripCurve(
        fingers=fingers,
        endpoint_m=tuple(map(float, endpoint_over_place.coef)),
        leverage=tuple(map(float, lever_over_place.coef)),
        finger_compliance_m_per_n=0.0,
        wire_compliance_m_per_n=0.0,
        power_per_newton_w=(1.0,),
        normalised_min=free.normalised_min,
        normalised_max=free.normalised_max,
    )


def columns_of(recording: Recording, free: FreeClosing) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return normalised resistance, connector and endpoint [m] of a closing."""
    closing = closing_of(recording, free.resistance_min_ohm, free.resistance_max_ohm)
    return (
        closing.normalised,
        recording["displacement_m"][closing.rows],
        recording["endpoint_displacement_m"][closing.rows],
    )


@dataclass(frozen=True)
class GripSamples:
    """The samples of a known grip with force: place, detected contact, additional power [W], force [N], (n,)."""

    place: FloatArray
    contact: FloatArray
    cost_w: FloatArray
    force_n: FloatArray
    stiffness_n_per_m: float


def grip_samples(grip: KnownGrip, free: FreeClosing) -> GripSamples:
    """Return the detector's results on a known grip, so that the fit includes the detector's own bias."""
    detector = ContactDetector(free)
    state = detector.start()
    resistance, power_w = electrical(grip.recording)
    dt_s = grip.recording.facts.sample_period_s
    if "endpoint_force_n" not in grip.recording:
        raise RecordingError("a grip of a known block needs a load cell between the fingers: endpoint_force_n")
    rows = []
    for ohm, watt, force_n in zip(resistance, power_w, grip.recording["endpoint_force_n"], strict=True):
        state = detector.step(state, float(ohm), float(watt), dt_s)
        place = state.normalised
        if state.touched and force_n > MIN_FORCE_N and place is not None and place > free.normalised_min:
            rows.append((place, state.place, state.slope_w * (state.place - place), force_n))
    places, contacts, costs, forces = np.array(rows).reshape(-1, 4).T
    return GripSamples(places, contacts, costs, forces, grip.stiffness_n_per_m)


def compliances(curve: GripCurve, grips: Sequence[GripSamples]) -> tuple[float, float]:
    """Return the compliances of finger and wire [m/N]: least squares of travel since contact over the force.

    D(l) - D(l_c) - f/k = n (c_f + c_w e'^2) f. Raises RecordingError if too few samples carry force.
    """
    samples = sum(one.force_n.size for one in grips)
    if samples < MIN_FORCE_SAMPLES:
        raise RecordingError(
            f"contact was found in {samples} samples above {MIN_FORCE_N:g} N of the known grips, and "
            f"{MIN_FORCE_SAMPLES} are needed: put the block nearer, or use a stiffer one"
        )
    endpoint, leverage = (np.polynomial.Polynomial(item) for item in (curve.endpoint_m, curve.leverage))
    per_finger = np.concatenate([curve.fingers * one.force_n for one in grips])
    lever = np.concatenate([leverage(one.place) for one in grips])
    travel = [
        curve.fingers * (endpoint(one.place) - endpoint(one.contact)) - one.force_n / one.stiffness_n_per_m
        for one in grips
    ]
    basis = np.column_stack([per_finger, per_finger * lever**2])
    finger, wire = nnls(basis / np.linalg.norm(basis, axis=0), np.concatenate(travel))[0] / np.linalg.norm(
        basis, axis=0
    )
    return float(finger), float(wire)


def power_per_newton_w(curve: GripCurve, grips: Sequence[GripSamples]) -> tuple[float, ...]:
    """Return the power per newton at a tendon [W]. Raises RecordingError if too few samples carry a grip's force."""
    leverage = np.polynomial.Polynomial(curve.leverage)
    place, force_n, cost_w = (
        np.concatenate([getattr(one, name) for one in grips]) for name in ("place", "force_n", "cost_w")
    )
    like_a_grip = force_n < MAX_COST_FORCE_N
    if (samples := np.count_nonzero(like_a_grip)) < MIN_FORCE_SAMPLES:
        raise RecordingError(
            f"the known grips have {samples} samples with contact found from {MIN_FORCE_N:g} to "
            f"{MAX_COST_FORCE_N:g} N, and {MIN_FORCE_SAMPLES} are needed: record more grips, or use a softer block"
        )
    tendon_n = (leverage(place) * force_n)[like_a_grip]
    basis = tendon_n[:, None] * np.vander(place[like_a_grip], COST_ORDER + 1, increasing=True)
    found = np.linalg.lstsq(basis, cost_w[like_a_grip], rcond=None)[0]
    return tuple(map(float, found))
