"""The inverse of the wire's model, and feedback on the state that the filter finds; state in, state out.

A wire in air is a heat balance with a play behind it. The filter follows it by four numbers: the steady power w, where
between the branches it is, how far today's air shifts both, d, and how much more heat it takes, e:

    tau dw/dt = P - e (w - d) - lambda dS/dt,   S rises on w_h(S), falls on w_c(S), and hardly moves between

So what an error takes is known: to cross what is left of the gap to the branch ahead, to go along that branch, and the
heat of the transformation. The drive gives the power that holds the wire where it is, and that heat within SIMC's
tau_c + theta (Skogestad 2003, doi 10.1016/S0959-1524(02)00062-8). Every sample asks how much heat is due: nothing
is given twice, and a wire that comes from cold, turns, or was blown upon is no case of its own. A target that moves is
met where it will be. Two integrals are left: the power that holds the wire, which follows the filter's as far as an
error counts, so that a wire at rest keeps its power and the filter sees from its motion how much the air takes; and
what part of the power that is asked for the wire is given.

An error counts as far as it is distinct from the estimate's deviation. A turn takes a larger one: between the branches
an estimate is worth less, and a wire that was turned for nothing has to be turned again.

An estimator without such a state (a user's own, a sensor) is served by the same code: the heat balance of the slow
loop's air gives w, held between both branches by where the quantity is; as far as it is held, today's air takes more or
less, in proportion to w.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.compiled import compiled, compiled_inner, row_in
from musclewire.controllers._controller import ControllerSetup, settings_of_kind, step_error
from musclewire.controllers._known_wire import (
    COOLING_SLOPE,
    HEATING_SLOPE,
    N_SETTINGS,
    N_TABLES,
    SETTINGS,
    TABLES,
    FeedforwardSettings,
    KnownWire,
    edge_w,
    heat_per_value,
    known_numbers,
    power_w,
    set_drive,
)
from musclewire.errors import CallerError
from musclewire.signals import (
    CONTROLLER_ANSWERS,
    UNKNOWN_WIRE,
    CompiledTick,
    ControlStep,
    Drive,
    QuantityEstimate,
    Reason,
)

STATE = np.dtype(
    [
        (name, np.float64)
        for name in (
            "started",  # 1 once there has been an estimate
            "drive_voltage_v",  # the drive [V] that is applied,
            "power_w",  # and the power [W] that it should give
            "given_part",  # what part of that power the wire is given
            "holding_w",  # the power [W] that holds the wire
            "target",  # the last target,
            "moved",  # and by how much it was another than the one before
            "balance_w",  # for an estimator without a state the steady power [W],
            "loss",  # how much heat today's air takes, in that of still air,
            "value",  # and the last value
        )
    ]
)
NO_CURRENT, COLD, NOT_READY = float(Reason.NO_CURRENT), float(Reason.COLD), float(Reason.NOT_READY)
# A record; mypy knows no fields of one.
Row = Any


class InverseModelNumbers(NamedTuple):
    """Numbers of the method, chosen by ``python studies/controller_numbers.py``."""

    # An error of so many deviations of the estimate counts half: fewer are quicker, and less quiet at rest.
    near: float = 0.5
    # So many deviations turn the wire half: fewer are quicker, and turn it for less than a turn costs.
    turn: float = 4.0
    # A wire is never taken to be given less than this part of the power that is asked for: less is a broken supply.
    min_part: float = 0.5


INVERSE_MODEL = InverseModelNumbers()
# What the tick reads of the gains, besides the tables and what is the rig's: drive limits and shunt.
OF_THE_WIRE = (
    *("thermal_time_constant_s", "heat_per_unit", "response_s", "integral_time_s", "maximum_steady_power_w"),
    *("lowest", "spacing"),
)
NUMBERS = np.dtype([(name, np.float64) for name in InverseModelNumbers._fields])
N_NUMBERS = len(InverseModelNumbers._fields)


class WireNow(NamedTuple):
    """What is known of the wire at a sample: steady power [W], part between the branches, and the power that holds."""

    balance_w: float
    part: float
    holding_w: float


@compiled
def inverse_model_tick(constants: FloatArray, state: FloatArray, given: FloatArray, answer: FloatArray) -> None:
    """Control by the power that holds the wire, and by the heat that its error takes."""
    row = row_in(state, STATE)
    method, known = row_in(constants, NUMBERS), constants[N_NUMBERS:]
    wire = KnownWire(row_in(known, SETTINGS), known[N_SETTINGS:].reshape(N_TABLES, -1))
    target, value, std, _, reason, dt_s, balance_w, part, shift_w, loss, measured_w = given
    answer[0], answer[1] = row["drive_voltage_v"], 0.0
    answer[2], answer[3], answer[4] = row["holding_w"], 0.0, 0.0
    if reason == NO_CURRENT:
        return
    if not math.isfinite(target - value - std) or not dt_s > 0.0 or not math.isfinite(dt_s):
        answer[1] = 1.0
        return
    cold = reason in (COLD, NOT_READY)
    if cold:
        value = min(value, wire.settings["lowest"])
    if row["started"] == 0.0:
        take_over(wire, row, target, value)
    wire_now = WireNow(balance_w, part, loss * (balance_w - shift_w))
    if measured_w > 0.0:  # a reading of another wire, or none, measures no power
        notice_given_part(method, wire, row, measured_w, dt_s)
    if not math.isfinite(wire_now.holding_w + part):
        wire_now = state_of_value(wire, row, value, cold, dt_s)
    if cold:
        trust, due_j = 1.0, due_from_cold_j(wire, wire_now, target)
    else:
        trust, due_j = due_at(method, wire, wire_now, target, value, std)
    row["holding_w"] += trust * (wire_now.holding_w - row["holding_w"])
    rate = target_rate(row, target, dt_s)
    ahead_w = rate * heat_per_value(wire, HEATING_SLOPE if rate > 0.0 else COOLING_SLOPE, target)
    wanted_w = row["holding_w"] + due_j / max(wire.settings["response_s"], dt_s) + ahead_w
    ceiling_w = wire.settings["maximum_steady_power_w"]
    # With this power, of which the wire is given its part, the heat balance is at the limit after this sample.
    warmest_w = wire_now.holding_w + (ceiling_w - wire_now.balance_w) * wire.settings["thermal_time_constant_s"] / dt_s
    lowest_w = power_w(wire, wire.settings["sense_voltage_v"], value)
    highest_w = power_w(wire, wire.settings["maximum_voltage_v"], value)
    asked_w = max(min(min(wanted_w, warmest_w) / row["given_part"], highest_w), lowest_w)
    set_drive(wire, row, value, asked_w, lowest_w, highest_w)
    row["value"] = value
    answer[0], answer[2], answer[3] = row["drive_voltage_v"], row["holding_w"], due_j
    answer[4] = 1.0 if wanted_w > warmest_w and warmest_w < highest_w else 0.0


@compiled_inner
def counted(error: float, deviation: float) -> float:
    """Return the part of an error that counts: half of one that is as large as a deviation."""
    squared = error * error
    return squared / (squared + deviation * deviation) if squared > 0.0 else 0.0


@compiled_inner
def due_at(
    method: Row, wire: KnownWire, wire_now: WireNow, target: float, value: float, std: float
) -> tuple[float, float]:
    """Return how much of the error counts, and the heat [J] that is due for it along the branch or to turn."""
    error = target - value
    rises = error > 0.0
    left = 1.0 - wire_now.part if rises else -wire_now.part
    turn = counted(error, method["turn"] * std)
    trust = counted(error, method["near"] * std) * (1.0 - abs(left) * (1.0 - turn))
    gap_w = edge_w(wire, 1.0, value) - edge_w(wire, -1.0, value)
    gap_j = turn * wire.settings["thermal_time_constant_s"] * left * gap_w
    return trust, gap_j + trust * heat_per_value(wire, HEATING_SLOPE if rises else COOLING_SLOPE, value) * error


@compiled_inner
def due_from_cold_j(wire: KnownWire, wire_now: WireNow, target: float) -> float:
    """Return the heat [J] that brings a cold wire to a target, from A on, where the quantity is 0."""
    warming_w = edge_w(wire, 1.0, target) - wire_now.balance_w
    return float(wire.settings["thermal_time_constant_s"] * warming_w + wire.settings["heat_per_unit"] * target)


@compiled_inner
def take_over(wire: KnownWire, state: Row, target: float, value: float) -> None:
    """Start from the drive that is applied, as one that has been there for long."""
    state["started"] = state["given_part"] = state["loss"] = 1.0
    state["power_w"] = power_w(wire, state["drive_voltage_v"], value)
    state["holding_w"] = state["balance_w"] = state["power_w"]
    state["target"], state["value"] = target, value


@compiled_inner
def target_rate(state: Row, target: float, dt_s: float) -> float:
    """Return how fast the target moves: what its last two moves have in common. A jump has no rate."""
    moved, before = target - state["target"], state["moved"]
    state["target"], state["moved"] = target, moved
    if moved * before <= 0.0:
        return 0.0
    return math.copysign(min(abs(moved), abs(before)), moved) / dt_s


@compiled_inner
def notice_given_part(method: Row, wire: KnownWire, state: Row, measured_w: float, dt_s: float) -> None:
    """Learn what part of the asked power the wire is given, the more of it the more power was asked for."""
    asked_w, ceiling_w = state["power_w"], wire.settings["maximum_steady_power_w"]
    lacking_w = measured_w - state["given_part"] * asked_w
    learnt = lacking_w * asked_w / (asked_w * asked_w + ceiling_w * ceiling_w)
    state["given_part"] += learnt * min(dt_s / wire.settings["integral_time_s"], 1.0)
    state["given_part"] = max(state["given_part"], method["min_part"])


@compiled_inner
def state_of_value(wire: KnownWire, state: Row, value: float, cold: bool, dt_s: float) -> WireNow:
    """Return the wire's state by its quantity alone: a heat balance, held between the branches."""
    tau_s, loss = wire.settings["thermal_time_constant_s"], state["loss"]
    taken_j = 0.0 if cold else wire.settings["heat_per_unit"] * (value - state["value"])
    lag_s = tau_s + dt_s * loss
    free_w = (tau_s * state["balance_w"] + dt_s * state["power_w"] - taken_j) / lag_s
    # A cold wire is at most as warm as on the way to B.
    cooling_w, heating_w = 0.0 if cold else edge_w(wire, -1.0, value), edge_w(wire, 1.0, value)
    held_w, part = min(max(free_w, cooling_w), heating_w), 1.0
    if held_w != free_w:
        lacking = (free_w - held_w) * lag_s / (dt_s * held_w)
        loss += lacking * min(dt_s / wire.settings["integral_time_s"], 1.0)
        state["loss"] = max(loss, 0.0)  # air gives no heat
    if not cold:
        part = (held_w - cooling_w) / (heating_w - cooling_w) if heating_w > cooling_w else 0.5
    state["balance_w"] = held_w
    return WireNow(state["balance_w"], part, state["loss"] * state["balance_w"])


def inverse_model_numbers(settings: FeedforwardSettings) -> tuple[dict[str, float], FloatArray]:
    """Return the tick's numbers by name, and its tables, (n, 5): both powers [W], resistance [ohm], both slopes."""
    known = known_numbers(settings)
    numbers = {name: float(known[name]) for name in OF_THE_WIRE}
    return numbers | INVERSE_MODEL._asdict(), np.column_stack([known[name] for name in TABLES])


class InverseModelController:
    """Gives the power that holds the wire and the heat of its error; brings a cold wire to a first target."""

    columns: tuple[str, ...] = ("steady_power_w", "pending_heat_j", "power_limited")
    # The first target is reached from cold within its first second, so it needs no time before the first step.
    approach_s = 0.0

    def __init__(self, setup: ControllerSetup, method: InverseModelNumbers = INVERSE_MODEL) -> None:
        """Take limits, settings and numbers, and pack them for the tick."""
        if setup.settings is None:
            raise CallerError(
                "the controller inverse-model needs the gains of its wire: fit keeps them in a new model, and for this "
                "one tune finds them: 'musclewire tune MODEL RECORDING', or settings=tune(model, recording).settings"
            )
        self.settings: FeedforwardSettings = settings_of_kind(setup, FeedforwardSettings)
        self.limits = setup.limits
        known = known_numbers(self.settings) | {
            "sense_voltage_v": self.limits.sense_voltage_v,
            "maximum_voltage_v": self.limits.maximum_voltage_v,
        }
        numbers = [known[name] for name in SETTINGS.names or ()]
        self._constants = np.concatenate([method, numbers, *(known[name] for name in TABLES)])
        self.step(self.start(self.limits.sense_voltage_v), 0.0, QuantityEstimate(0.0, 0.0, True), 1.0)

    def start(self, drive_voltage_v: float) -> tuple[float, ...]:
        """Return the state before the first estimate: the applied drive [V], within the limits."""
        state = np.zeros(1, STATE)
        state["drive_voltage_v"] = self.limits.clamp(float(drive_voltage_v))
        return tuple(state.view(np.float64).tolist())

    def step(self, state: tuple[float, ...], target: float, estimate: QuantityEstimate, dt_s: float) -> ControlStep:
        """Return the drive for an estimate; without current the last one."""
        numbers, answer = np.array(state), np.zeros(len(CONTROLLER_ANSWERS) + len(self.columns))
        wire = UNKNOWN_WIRE if estimate.wire is None else estimate.wire
        given = np.array((target, *estimate[:4], dt_s, *wire), dtype=np.float64)
        inverse_model_tick(self._constants, numbers, given, answer)
        drive_voltage_v, failed, *recorded = answer.tolist()
        if failed:
            raise step_error(target, estimate.value, dt_s)
        return ControlStep(Drive(drive_voltage_v), tuple(numbers.tolist()), tuple(recorded))

    def compiled_tick(self, drive_voltage_v: float) -> CompiledTick:
        """Return ``step`` as a compiled function."""
        return CompiledTick(inverse_model_tick, self._constants, np.array(self.start(drive_voltage_v)))
