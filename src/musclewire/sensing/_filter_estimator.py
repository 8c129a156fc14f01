"""The filter: a Kalman filter on one model of the wire, its heat balance with a play behind it (``_wire_model``).

The state is the steady power w, the place v of the play, the power d by which today's air shifts both branches, and the
factor e of today's heat loss:

    tau dw/dt = P - e (w - d) - heat dv/dt,   v rises on w_h(v), falls on w_c(v), and hardly moves between

Power drives it, the measured resistance corrects it. How far between the branches the wire is then chooses the quantity
between both polynomials of the resistance as it was read: an error of the model's level does not count, only one of
that part. Before B the resistance rises with the place and after it it falls; that is in the tables, and B is passed as
any other place is. A reading that the state does not explain makes place and power as uncertain as it takes, so that a
wire that is lost is found again; and the heat loss, too, if it says that the wire goes against its power. Eight points
about the mean say what a change does (cubature, Arasaratnam and Haykin 2009, doi 10.1109/TAC.2009.2019800), and not a
slope at it, which a play does not have at a branch.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.compiled import callback, compiled, compiled_inner, row_in
from musclewire.sensing._curve import MARGIN, Row, branches, row_type
from musclewire.sensing._curve_estimator import (
    ESTIMATOR_NUMBERS,
    N_ARRAYS,
    CurveEstimator,
    add_friction,
    answer_with,
    answer_without_current,
    estimator_numbers,
    resistance_of,
)
from musclewire.sensing._estimator import EstimatorSetup
from musclewire.sensing._fit_report import FittedCurve
from musclewire.sensing._known_load import KnownSpring
from musclewire.sensing._polynomial_estimator import polynomial_tick
from musclewire.sensing._wire_model import wire_model_of
from musclewire.sensing._wire_tables import PLACES, WireModel
from musclewire.signals import CompiledTick, Reason, WireEstimate


class FilterNumbers(NamedTuple):
    """Numbers of the method, chosen by ``python studies/filter_numbers.py choose`` on wires of the tuning seeds.

    Powers count in the loop's middle power, resistance in R_max - R_min, times in seconds.
    """

    power_walk: float = 0.0083  # random walk of the steady power, per square root of a second
    power_part: float = 0.42  # error of its change in a sample, as a part of it: what the heat balance leaves out
    shift_std: float = 0.04  # deviation of the shift of the branches by other air
    # Random walk of the factor of the heat loss, per square root of a second, where readings surprise as much as the
    # covariance expects; in proportion to the mean of their squares, so that it is agile in draughts and rests in still
    # air. A run begins without any surprise, and so a first rise that is a little faster than the model's is not taken
    # for calmer air. By estimates alone half of it is as good; loops in draughts are better with it.
    loss_walk: float = 0.02
    unrest_s: float = 6.0  # time over which these squares are taken
    place_walk: float = 0.0007  # per square root of a second
    # A run begins with what the walks have become after this time, and learns the noise of readings over it.
    walked_s: float = 30.0
    resistance_std: float = 0.0035  # error of the model's resistance
    # How late between the branches the R-phase's resistance comes: 0 in proportion to the way, 1 with its square.
    phase_lag: float = 0.5
    # How far the place follows the power between the branches already, as a part of what the branch ahead does: 0 is a
    # play, and with 1 there is none.
    looseness: float = 0.042
    # Squared deviations by which a reading may surprise before the state counts as less certain; a second difference of
    # readings counts for their noise as no more.
    surprise: float = 9.0
    range_std: float = 0.006  # what differs from wire to wire, as a part of the range of the quantity


FILTER = FilterNumbers()
# The numbers of a wire's model, by name: see ``wire_numbers``. The tables follow the numbers, a row for each place.
WIRE_NUMBERS = (
    *("time_constant_s", "transformation_heat_j", "phase_resistance", "sensed_from", "middle_w"),
    *("first_place", "last_place", "per_place", "least_slope_w", "least_noise_v2"),
)
FILTER_CONSTANTS = (*ESTIMATOR_NUMBERS, *WIRE_NUMBERS, *FilterNumbers._fields)
N_CONSTANTS = len(FILTER_CONSTANTS)
COLUMNS = 4  # numbers of a place in the tables: the power and the resistance of either branch
N_TABLES = COLUMNS * PLACES
OK, COLD = float(Reason.OK), float(Reason.COLD)
OUT_OF_RANGE, MISMATCH = float(Reason.OUT_OF_RANGE), float(Reason.MISMATCH)
STATES = 4  # of the filter: steady power, place, shift of the branches and factor of the heat loss
POINTS = 8  # of the cubature rule: two for each state, one to either side of the mean
AWAY = 2.0  # standard deviations from the mean to each point: the root of the number of states
# A cold wire reads at least this part of the model's resistance there: a scale that is 1 % off takes a tenth of it.
COLD_FROM = 0.9
# Of a mean of surprises one reading is no more than this part: of loops of minutes with few samples one would decide.
MAX_WEIGHT = 0.1
# From B to C the resistance falls by 1 over places of about 1: where a table is flatter than this it says no place.
MIN_FALL = 0.1
MIN_VARIANCE = 1e-16  # a smaller variance cannot be distinguished from rounding
MIN_LOSS = 0.05  # of the heat loss in the loop: no air cools a wire by a smaller factor


class FilterState(NamedTuple):
    """State of the filter between two samples; all are numbers."""

    value: float  # the quantity, and on a known spring the friction
    friction_n: float  # on a known spring
    dropouts: float = 0.0  # samples in a row without current
    mismatches: float = 0.0  # samples in a row with another wire's resistance
    spring_known: float = 0.0  # 1 once the force of a known spring has been estimated
    spring_force_n: float = 0.0
    followed: float = 0.0  # 1 once there has been a sample; before it the numbers below do not count
    time_s: float = 0.0
    before: float = 0.0  # the last two readings of the normalised resistance
    before_last: float = 0.0
    noise_v2: float = 0.0  # variance of a reading, referred to the shunt's voltage
    learnt_s: float = 0.0  # time from which the variance is known
    unrest: float = 0.0  # mean of the squares by which readings surprise, in what the covariance expects
    steady_w: float = 0.0  # the mean: steady power, place, shift of the branches and factor of the heat loss
    place: float = 0.0
    shift_w: float = 0.0
    loss: float = 1.0
    covariance_00: float = 0.0  # lower triangle of the covariance of these four, row by row
    covariance_10: float = 0.0
    covariance_11: float = 0.0
    covariance_20: float = 0.0
    covariance_21: float = 0.0
    covariance_22: float = 0.0
    covariance_30: float = 0.0
    covariance_31: float = 0.0
    covariance_32: float = 0.0
    covariance_33: float = 0.0


NUMBERS_ROW, STATE_ROW = row_type(FILTER_CONSTANTS), row_type(FilterState._fields)
FIRST_COVARIANCE = FilterState._fields.index("covariance_00")


class Filtered(NamedTuple):
    """What a tick works on: numbers, state, the covariance in it, and the tables."""

    numbers: Row
    state: Row
    covariance: FloatArray
    tables: FloatArray


class Edges(NamedTuple):
    """Both branches at a place: steady powers [W] and their slopes over the place, and resistances."""

    heating_w: float
    cooling_w: float
    heating_slope_w: float
    cooling_slope_w: float
    heating: float
    cooling: float


@compiled_inner
def edges_at(numbers: Row, tables: FloatArray, place: float) -> Edges:
    """Return both branches at a place; beyond the ends of the tables they go straight on."""
    at = (place - numbers.first_place) * numbers.per_place
    left = int(min(max(at, 0.0), PLACES - 2.0))
    part, row, following = at - left, COLUMNS * left, COLUMNS * (left + 1)
    rise_w, fall_w = tables[following] - tables[row], tables[following + 1] - tables[row + 1]
    return Edges(
        tables[row] + part * rise_w,
        tables[row + 1] + part * fall_w,
        rise_w * numbers.per_place,
        fall_w * numbers.per_place,
        tables[row + 2] + part * (tables[following + 2] - tables[row + 2]),
        tables[row + 3] + part * (tables[following + 3] - tables[row + 3]),
    )


@compiled_inner
def part_between(steady_w: float, edges: Edges) -> float:
    """Return where between the cooling branch (0) and the heating branch (1) a steady power is."""
    return min(max((steady_w - edges.cooling_w) / (edges.heating_w - edges.cooling_w), 0.0), 1.0)


@compiled_inner
def sag(numbers: Row, part: float) -> float:
    """Return by how much the resistance between the branches is below the line from one to the other."""
    return float(numbers.phase_lag * numbers.phase_resistance * part * (1.0 - part))


@compiled_inner
def modelled(numbers: Row, tables: FloatArray, steady_w: float, place: float) -> float:
    """Return the normalised resistance of a steady power at a place."""
    edges = edges_at(numbers, tables, place)
    part = part_between(steady_w, edges)
    line = edges.cooling + part * (edges.heating - edges.cooling)
    return line - sag(numbers, part) if place > numbers.sensed_from else line


@compiled_inner
def is_sensed(numbers: Row, state: Row, covariance: FloatArray) -> bool:
    """Return whether all points of the place are past B."""
    return bool(state.place - AWAY * math.sqrt(covariance[2]) > numbers.sensed_from)


@compiled_inner
def lengthened(dt_s: float, loss: float, heat_s: float) -> float:
    """Return the time of one implicit step that does what the exponential does: to the second order in it."""
    return dt_s * (1.0 + 0.5 * dt_s * loss / heat_s)


@compiled_inner
def warmed(steady_w: float, heat_s: float, given_w: float, loss: float, dt_s: float) -> float:
    """Return the steady power after a time, where a watt of it takes this heat."""
    step_s = lengthened(dt_s, loss, heat_s)
    return (heat_s * steady_w + step_s * given_w) / (heat_s + step_s * loss)


@compiled_inner
def loose_per_watt(numbers: Row, edges: Edges, steady_w: float, toward_w: float) -> float:
    """Return by how much the place follows the power between the branches: the more the nearer the branch ahead."""
    part, ahead_w = part_between(steady_w, edges), edges.heating_slope_w
    if toward_w < steady_w:
        part, ahead_w = 1.0 - part, edges.cooling_slope_w
    return float(numbers.looseness * part / max(ahead_w, numbers.least_slope_w))


@compiled_inner
def advanced(
    numbers: Row,
    tables: FloatArray,
    steady_w: float,
    place: float,
    shift_w: float,
    loss: float,
    power_w: float,
    dt_s: float,
) -> tuple[float, float]:
    """Return steady power and place after a time at a power: an implicit step, on a branch that it meets."""
    tau_s, loss = numbers.time_constant_s, max(loss, MIN_LOSS)
    given_w = power_w + loss * shift_w
    free_w = warmed(steady_w, tau_s, given_w, loss, dt_s)
    edges = edges_at(numbers, tables, place)
    if edges.cooling_w <= free_w <= edges.heating_w:
        per_watt = loose_per_watt(numbers, edges, steady_w, free_w)
        heat_s = tau_s + (numbers.transformation_heat_j if place > numbers.sensed_from else 0.0) * per_watt
        reached_w = warmed(steady_w, heat_s, given_w, loss, dt_s)
        loose = place + per_watt * (reached_w - steady_w)
        return reached_w, min(max(loose, numbers.first_place), numbers.last_place)
    rises = free_w > edges.heating_w
    at, takes_j, given_j, per_w = place, 0.0, 0.0, 1.0
    for _ in range(2):  # with the slope here, then with that of the cell where it led
        branch_w, slope_w = edges.cooling_w, edges.cooling_slope_w
        if rises:
            branch_w, slope_w = edges.heating_w, edges.heating_slope_w
        slope_w = max(slope_w, numbers.least_slope_w)
        takes_j = numbers.transformation_heat_j if at > numbers.sensed_from else 0.0
        step_s = lengthened(dt_s, loss, tau_s + takes_j / slope_w)
        given_j = tau_s * steady_w + step_s * given_w
        per_w = tau_s + step_s * loss
        found = (given_j + takes_j * place - per_w * (branch_w - slope_w * at)) / (takes_j + per_w * slope_w)
        found = max(found, place) if rises else min(found, place)
        at = min(max(found, numbers.first_place), numbers.last_place)
        edges = edges_at(numbers, tables, at)
    return (given_j - takes_j * (at - place)) / per_w, at


@compiled_inner
def write_cholesky_factor(covariance: FloatArray, root: FloatArray) -> None:
    """Write the Cholesky factor of a covariance; both are lower triangles, row by row."""
    for row in range(STATES):
        first = row * (row + 1) // 2
        for column in range(row + 1):
            other = column * (column + 1) // 2
            left = covariance[first + column]
            for before in range(column):
                left -= root[first + before] * root[other + before]
            if row == column:
                root[first + column] = math.sqrt(max(left, MIN_VARIANCE))
            else:
                root[first + column] = left / root[other + column]


@compiled
def filter_tick(constants: FloatArray, state_array: FloatArray, given: FloatArray, answer: FloatArray) -> None:
    """Estimate one sample; ``signals._compiled_tick`` says what is where in ``given`` and ``answer``."""
    numbers, state = row_in(constants, NUMBERS_ROW), row_in(state_array, STATE_ROW)
    tables = constants[N_CONSTANTS : N_CONSTANTS + N_TABLES]
    filtered = Filtered(numbers, state, state_array[FIRST_COVARIANCE:], tables)
    wire_voltage_v, shunt_voltage_v = given[2], given[3]
    resistance_ohm = resistance_of(numbers, wire_voltage_v, shunt_voltage_v)
    at_rest = part_between(state.steady_w, edges_at(numbers, tables, state.place))
    answer_with_wire(state, answer, at_rest, 0.0)
    if resistance_ohm == 0.0:
        answer_without_current(numbers, state, answer)
        return
    state.dropouts = 0.0
    if not numbers.own_low_ohm <= resistance_ohm <= numbers.own_high_ohm:
        state.mismatches += 1.0
        answer_with(answer, state.value, numbers.quantity_span, MISMATCH, state.mismatches, resistance_ohm)
        return
    state.mismatches = 0.0
    power_w = wire_voltage_v * wire_voltage_v / resistance_ohm
    read = (resistance_ohm - numbers.resistance_min_ohm) * numbers.per_ohm
    # What one volt of noise at the shunt is in normalised resistance.
    per_volt = resistance_ohm * numbers.per_ohm / shunt_voltage_v
    if state.followed == 0.0:
        begin(filtered, read, power_w, given[0])
    dt_s = given[0] - state.time_s
    state.time_s = given[0]
    noise = learnt_noise(numbers, state, read, dt_s, per_volt)
    change_w = predict(filtered, power_w, dt_s) if dt_s > 0.0 else 0.0
    correct(filtered, read, noise, dt_s, change_w)
    quantity, variance, part = quantity_of(filtered, constants[N_CONSTANTS + N_TABLES :], read, noise)
    sensed = is_sensed(numbers, state, filtered.covariance)
    if numbers.stiffness_n_per_m > 0.0:
        add_friction(numbers, state, quantity)
    state.value = quantity + state.friction_n
    outside = max(numbers.valid_from - read, read - 1.0 - MARGIN, 0.0)
    reason = OK if sensed else COLD
    if outside * outside > 9.0 * noise:
        reason = OUT_OF_RANGE
    std = math.sqrt(variance + numbers.scale_variance * quantity * quantity)
    answer_with(answer, state.value, min(std, numbers.quantity_span), reason, 0.0, resistance_ohm)
    answer_with_wire(state, answer, part, power_w)


@compiled_inner
def answer_with_wire(state: Row, answer: FloatArray, part: float, power_w: float) -> None:
    """Write what a ``WireEstimate`` has."""
    answer[6], answer[7], answer[8], answer[9], answer[10] = state.steady_w, part, state.shift_w, state.loss, power_w


@compiled_inner
def begin(filtered: Filtered, read: float, power_w: float, time_s: float) -> None:
    """Begin where resistance is, anywhere between the branches; or cold, if power holds no other.

    Where resistance may be that of a cold wire and power would hold another, the drive may just have come: the wire is
    anywhere on the way from cold. How far is as uncertain as that, and with the power the place.
    """
    numbers, state, covariance, tables = filtered
    row, gap_w, way = PLACES - 1, 0.0, 0.0
    while row > 0 and tables[COLUMNS * row + 2] + tables[COLUMNS * row + 3] < 2.0 * read:
        row -= 1
    there = numbers.first_place + row / numbers.per_place
    if read > COLD_FROM * tables[2]:
        state.steady_w = power_w
        if power_w >= edges_at(numbers, tables, numbers.sensed_from).cooling_w:
            way = max(there, numbers.sensed_from) - numbers.first_place
            gap_w = edges_at(numbers, tables, numbers.first_place + way).heating_w
            state.steady_w = 0.5 * gap_w
        row = 0
        while row < PLACES - 1 and tables[COLUMNS * row] <= state.steady_w:
            row += 1
    else:
        edges, further = edges_at(numbers, tables, there), edges_at(numbers, tables, there + 1.0 / numbers.per_place)
        fall = 0.5 * (edges.heating + edges.cooling - further.heating - further.cooling) * numbers.per_place
        gap_w, way = edges.heating_w - edges.cooling_w, (edges.heating - edges.cooling) / max(fall, MIN_FALL)
        state.steady_w = min(max(power_w, edges.cooling_w), edges.heating_w)
    walk_w, shift_w = numbers.power_walk * numbers.middle_w, numbers.shift_std * numbers.middle_w
    covariance[:] = 0.0
    covariance[0] = walk_w * walk_w * numbers.walked_s + gap_w * gap_w / 12.0
    covariance[1] = gap_w * way / 12.0
    covariance[2] = numbers.place_walk * numbers.place_walk * numbers.walked_s + way * way / 12.0
    covariance[5] = shift_w * shift_w
    covariance[9] = numbers.loss_walk * numbers.loss_walk * numbers.walked_s
    state.place = numbers.first_place + row / numbers.per_place
    state.followed, state.time_s, state.shift_w, state.loss = 1.0, time_s, 0.0, 1.0
    state.before = state.before_last = read
    state.noise_v2, state.learnt_s, state.unrest = numbers.least_noise_v2, 1.0, 0.0


@compiled_inner
def learnt_noise(numbers: Row, state: Row, read: float, dt_s: float, per_volt: float) -> float:
    """Return the variance of a reading, learnt from the second differences of the readings."""
    bend_v = (read - 2.0 * state.before + state.before_last) / per_volt
    state.before_last = state.before
    state.before = read
    if dt_s > 0.0:
        state.learnt_s = min(state.learnt_s + dt_s, numbers.walked_s)
        new_v2 = min(bend_v * bend_v / 6.0, numbers.surprise * state.noise_v2)
        state.noise_v2 += (new_v2 - state.noise_v2) * min(dt_s / state.learnt_s, 1.0)
        state.noise_v2 = max(state.noise_v2, 0.25 * numbers.least_noise_v2)
    return float(state.noise_v2 * per_volt * per_volt)


@compiled_inner
def predict(filtered: Filtered, power_w: float, dt_s: float) -> float:
    """Take mean and covariance through the heat balance and the play, add what these leave out; return the change."""
    numbers, state, covariance, tables = filtered
    root, powers, places = np.zeros(STATES * STATES), np.empty(POINTS), np.empty(POINTS)
    write_cholesky_factor(covariance, root)
    mean_w = mean_place = 0.0
    for point in range(POINTS):
        column, away = point // 2, AWAY - 2.0 * AWAY * (point % 2)
        # A triangle's column begins at its diagonal: what is above it is 0.
        first_w = state.steady_w + (away * root[0] if column == 0 else 0.0)
        place = state.place + (away * root[1 + column] if column <= 1 else 0.0)
        shift_w = state.shift_w + (away * root[3 + column] if column <= 2 else 0.0)
        loss = state.loss + away * root[6 + column]
        powers[point], places[point] = advanced(numbers, tables, first_w, place, shift_w, loss, power_w, dt_s)
        mean_w += powers[point] / POINTS
        mean_place += places[point] / POINTS
    change_w = mean_w - state.steady_w
    state.steady_w, state.place = mean_w, mean_place
    covariance[0] = covariance[1] = covariance[2] = covariance[3] = covariance[4] = covariance[6] = covariance[7] = 0.0
    for point in range(POINTS):
        column, away = point // 2, (AWAY - 2.0 * AWAY * (point % 2)) / POINTS
        off_w, off_place = powers[point] - mean_w, places[point] - mean_place
        covariance[0] += off_w * off_w / POINTS
        covariance[1] += off_w * off_place / POINTS
        covariance[2] += off_place * off_place / POINTS
        if column <= 2:
            covariance[3] += off_w * away * root[3 + column]
            covariance[4] += off_place * away * root[3 + column]
        covariance[6] += off_w * away * root[6 + column]
        covariance[7] += off_place * away * root[6 + column]
    walk_w, part_w = numbers.power_walk * numbers.middle_w, numbers.power_part * change_w
    covariance[0] += walk_w * walk_w * dt_s + part_w * part_w
    covariance[2] += numbers.place_walk * numbers.place_walk * dt_s
    if covariance[9] < 1.0:  # a factor of two is as much as is not known of a wire that has been cold for hours
        walk = numbers.loss_walk * state.unrest
        covariance[9] += walk * walk * dt_s
    return float(change_w)


@compiled_inner
def widened(wider: float, known: float) -> float:
    """Return by how much a deviation is wider, if its variance is by this and no wider than what is known."""
    return math.sqrt(min(wider, max(known, 1.0)))


@compiled_inner
def correct(filtered: Filtered, read: float, noise: float, dt_s: float, change_w: float) -> None:
    """Correct mean and covariance by a reading; one that they do not explain makes them wider before that.

    A play follows its power. Where the reading takes the place against the change of the power, the heat balance that
    predicted the change does not hold, and the heat loss is made as uncertain; not before B, where a resistance that is
    a hundredth off goes either way. The resistance is one of power and place alone, so that four of the eight points
    are in the middle.
    """
    numbers, state, covariance, tables = filtered
    root, wide = np.empty(STATES * STATES), np.ones(STATES)
    write_cholesky_factor(covariance, root)
    steady_w, place = state.steady_w, state.place
    middle = modelled(numbers, tables, steady_w, place)
    own = numbers.resistance_std * numbers.resistance_std
    known_w2 = numbers.middle_w * numbers.middle_w
    variance, surprise, by_w, by_place = 1.0, 0.0, 0.0, 0.0
    sensed = is_sensed(numbers, state, covariance)
    for turn in range(3):
        hotter = modelled(numbers, tables, steady_w + AWAY * root[0], place + AWAY * root[1])
        colder = modelled(numbers, tables, steady_w - AWAY * root[0], place - AWAY * root[1])
        farther = modelled(numbers, tables, steady_w, place + AWAY * root[2])
        nearer = modelled(numbers, tables, steady_w, place - AWAY * root[2])
        mean = (4.0 * middle + hotter + colder + farther + nearer) / POINTS
        spread = 4.0 * (middle - mean) ** 2 + (hotter - mean) ** 2 + (colder - mean) ** 2
        spread = (spread + (farther - mean) ** 2 + (nearer - mean) ** 2) / POINTS
        variance = spread + noise + own
        surprise = read - mean
        by_w, by_place = AWAY * (hotter - colder) / POINTS, AWAY * (farther - nearer) / POINTS
        if turn == 0:
            unrest = min(surprise * surprise / variance, numbers.surprise)
            state.unrest += (unrest - state.unrest) * min(dt_s / numbers.unrest_s, MAX_WEIGHT)
        wider = surprise * surprise / (numbers.surprise * variance)
        if wider <= 1.0:
            break
        # No wider than if nothing were known: of the power its middle, of the place the whole way.
        wide[0] = widened(wider, known_w2 / (root[0] * root[0]))
        wide[1] = widened(wider, 1.0 / (root[1] * root[1] + root[2] * root[2]))
        wide[3] = 1.0
        if sensed and surprise * (root[1] * by_w + root[2] * by_place) * change_w < 0.0:
            wide[3] = widened(wider, 1.0 / covariance[9])
        for row in range(STATES):
            for column in range(row + 1):
                root[row * (row + 1) // 2 + column] *= wide[row]
                covariance[row * (row + 1) // 2 + column] *= wide[row] * wide[column]
    gains = (
        root[0] * by_w,
        root[1] * by_w + root[2] * by_place,
        root[3] * by_w + root[4] * by_place,
        root[6] * by_w + root[7] * by_place,
    )
    per = surprise / variance
    state.place = min(max(place + gains[1] * per, numbers.first_place), numbers.last_place)
    edges = edges_at(numbers, tables, state.place)
    state.steady_w = min(max(steady_w + gains[0] * per, edges.cooling_w), edges.heating_w)
    state.shift_w += gains[2] * per
    state.loss = max(state.loss + gains[3] * per, MIN_LOSS)
    for row in range(STATES):
        for column in range(row + 1):
            covariance[row * (row + 1) // 2 + column] -= gains[row] * gains[column] / variance


@compiled_inner
def quantity_of(filtered: Filtered, coefficients: FloatArray, read: float, noise: float) -> tuple[float, float, float]:
    """Return the quantity, its variance, and the part of the way from the cooling to the heating branch."""
    numbers, state, covariance, tables = filtered
    edges = edges_at(numbers, tables, state.place)
    part = part_between(state.steady_w, edges)
    own = numbers.resistance_std * numbers.resistance_std
    error = modelled(numbers, tables, state.steady_w, state.place) - read
    on_line = read + error * noise / (own + noise) + sag(numbers, part)
    inside = min(max(on_line, numbers.normalised_min), numbers.normalised_max)
    hot, cold, slope = branches(coefficients, inside)
    gap = hot - cold
    per_w = gap / (edges.heating_w - edges.cooling_w)
    per_place = -per_w * (edges.cooling_slope_w + part * (edges.heating_slope_w - edges.cooling_slope_w))
    of_part = per_w * per_w * covariance[0] + per_place * per_place * covariance[2]
    of_part = min(max(of_part + 2.0 * per_w * per_place * covariance[1], 0.0), gap * gap / 12.0)
    off, slope, range_std = on_line - inside, 0.5 * slope, numbers.range_std * numbers.quantity_span
    of_reading = slope * slope * (noise * own / (own + noise) + off * off)
    variance = of_part + of_reading + numbers.residual_variance + range_std * range_std
    return part * hot + (1.0 - part) * cold, variance, part


class FilterEstimator(CurveEstimator):
    """Estimates by a Kalman filter on the wire's heat balance, with a play between its branches.

    Its ``step`` is that of every estimator with a curve; ``filter_tick`` is what runs in it.
    Raises CallerError for a model without a slow loop, or with one that does not go through B to C.
    """

    columns = ("wire_resistance_ohm", *WireEstimate._fields)

    def __init__(
        self,
        model: FittedCurve,
        shunt_resistance_ohm: float,
        load: KnownSpring | None = None,
        method: FilterNumbers = FILTER,
    ) -> None:
        """Take the numbers; the state of a run is not kept here."""
        curve = model.curve()
        own, tables = filter_numbers(model, shunt_resistance_ohm, method)
        numbers = estimator_numbers(curve, shunt_resistance_ohm, load) | own
        first_state = FilterState(curve.quantity_min, numbers["load_friction_n"])
        row = [*(numbers[name] for name in FILTER_CONSTANTS), *tables.ravel().tolist()]
        super().__init__(curve, filter_tick, row, first_state)

    def compiled_tick(self) -> CompiledTick:
        """Return the tick that ``step`` runs."""
        return self._tick


def filter_numbers(
    model: FittedCurve, shunt_resistance_ohm: float, method: FilterNumbers = FILTER
) -> tuple[dict[str, float], FloatArray]:
    """Return wire's and method's numbers by name, for the tick's row and the header of its form in C, and tables."""
    wire = wire_model_of(model)
    literals = {
        "min_variance": MIN_VARIANCE,
        "min_loss": MIN_LOSS,
        "margin": MARGIN,
        "cold_from": COLD_FROM,
        "min_fall": MIN_FALL,
        "max_weight": MAX_WEIGHT,
    }
    return wire_numbers(model, wire, shunt_resistance_ohm) | method._asdict() | literals, wire.tables


def wire_numbers(model: FittedCurve, wire: WireModel, shunt_resistance_ohm: float) -> dict[str, float]:
    """Return the numbers of a wire's model that the tick reads, by name."""
    _, power_w, resistance_ohm = (float(np.median(column)) for column in np.array(model.slow_loop).T)
    noise_v = model.resistance_noise_ohm / resistance_ohm * math.sqrt(power_w / resistance_ohm) * shunt_resistance_ohm
    return {
        "time_constant_s": wire.time_constant_s.value,
        "transformation_heat_j": wire.heat_j_per_unit.value * model.quantity_max,
        "phase_resistance": wire.phase_resistance.value,
        "sensed_from": wire.sensed_from.value,
        "middle_w": wire.middle_power_w,
        "first_place": wire.first_place,
        "last_place": wire.first_place + wire.place_spacing * (PLACES - 1),
        "per_place": 1.0 / wire.place_spacing,
        "least_slope_w": 1e-3 * float(np.ptp(wire.heating_power_w)),
        "least_noise_v2": noise_v * noise_v,
    }


def compile_estimators() -> None:
    """Compile the ticks of the estimators on a curve, for a program that makes them later, with a rig switched on."""
    for tick in (polynomial_tick, filter_tick):
        callback(tick, N_ARRAYS)


def filter_estimator(setup: EstimatorSetup) -> FilterEstimator:
    """Return the Kalman filter on the wire's model for a loop."""
    return FilterEstimator(setup.model, setup.shunt_resistance_ohm, setup.load)
