"""A closed loop of a simulated rig in compiled code: what of the rig goes in, and the columns that come out.

A drive that is known beforehand is one too, with a controller that looks at nothing.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from copy import deepcopy
from typing import NamedTuple

import numpy as np

from musclewire.arrays import FloatArray, IntArray
from musclewire.compiled import callback
from musclewire.controllers import State
from musclewire.errors import CallerError, argument
from musclewire.rigs._air import AirModel
from musclewire.rigs._compiled_loop.kernel import (
    RIG_COLUMNS,
    CompiledLoopEnd,
    LoopArrays,
    RigArrays,
    no_estimate,
    run_loop,
    scheduled_drive,
)
from musclewire.rigs._guarded import GuardedRig
from musclewire.rigs._simulated import SimulatedDevice
from musclewire.signals import CONTROLLER_ANSWERS, ELECTRICAL_COLUMNS, ESTIMATOR_ANSWERS, CompiledTick, WireEstimate
from musclewire.wire import OneWire, WireState, plan_of


class LoopTicks(NamedTuple):
    """The ticks of a loop, and the names of the columns that each of them records."""

    estimator: CompiledTick
    controller: CompiledTick
    estimator_columns: tuple[str, ...]
    controller_columns: tuple[str, ...]


class CompiledRun(NamedTuple):
    """How a compiled loop ended, how many samples are complete, and the columns of the rig, ticks and targets."""

    ended: CompiledLoopEnd
    samples: int
    columns: dict[str, FloatArray]
    true: FloatArray  # of the wire's state at the end of each sample, as asked for, (n_samples, n_names)
    controller: CompiledTick  # as it is at the end, to go on from
    next_drive_v: float


def uncompiled(rig: GuardedRig, state: State = State.ARMED) -> str:
    """Return what of a rig has no compiled form, in words; "" for a rig in such a state whose loop can be compiled."""
    device = rig.device
    if not isinstance(device, SimulatedDevice):
        return "the rig is not simulated"
    if device.facts.paced:
        return "the rig is paced by the machine's clock"
    if device.uncompiled:
        return device.uncompiled
    if device.air is not None and device.air.loss < 1.0:
        return "its air takes less heat than still air, which is watched sample by sample"
    if not isinstance(device.wires, OneWire):
        return "the rig has two wires"
    if rig.protection.state is not state:
        return "the rig is being driven, or has failed"
    return ""


def parts_of(rig: GuardedRig, state: State = State.ARMED) -> tuple[SimulatedDevice, OneWire]:
    """Return device and wire of a rig whose loop can be compiled. Raises CallerError for another rig."""
    reason = uncompiled(rig, state)
    if reason:
        raise CallerError(
            f"this loop has no compiled form, because {reason}: run it in Python (" + argument("in_python", True) + ")"
        )
    assert isinstance(rig.device, SimulatedDevice)
    assert isinstance(rig.device.wires, OneWire)
    return rig.device, rig.device.wires


def times_on_rig_s(rig: GuardedRig, samples: int) -> FloatArray:
    """Return the times of a rig's next samples on its clock [s], (n_samples,), as its steps will add them up."""
    _, wire = parts_of(rig)
    return sample_times_s(wire, rig.sample_period_s, samples)


def sample_times_s(wire: OneWire, sample_period_s: float, samples: int) -> FloatArray:
    """Return the times at the ends of a wire's next samples [s], (n_samples,), as the kernel adds them up."""
    time_s, times = wire.time_s, np.empty(samples)
    for row in range(samples):
        time_s += sample_period_s
        times[row] = time_s
    return times


def to_the_end(_run: CompiledRun) -> None:
    """Say that a run ends where it was to end."""


def run_compiled(
    rig: GuardedRig,
    ticks: LoopTicks,
    elapsed_s: FloatArray,
    targets: FloatArray,
    first_drive_v: float,
    true_names: Sequence[str] = (),
    *,
    ends_after: Callable[[CompiledRun], int | None] = to_the_end,
    state: State = State.ARMED,
) -> CompiledRun:
    """Run a closed loop from the present state of a rig, and leave the rig as these samples leave it.

    A rig to which something unusual happens on the way is left as it was before. ``ends_after`` may say after how many
    samples the run is to end instead. ``targets``, (2, n_samples), are those that held while each sample was taken and
    those that hold after it. A loop that goes on finds the protection in the state RUN. The interpreter is free
    meanwhile: loops of several rigs run in threads. Raises CallerError for a rig whose loop has no compiled form.
    """
    device, wire = parts_of(rig, state)
    samples, period_s = targets.shape[1], rig.sample_period_s
    noise, generator = device.instruments.noise_ahead(samples)
    air = deepcopy(device.air)
    of_wire = wire.state.copy()
    derived, cells, load = wire.constants.step_arrays()
    places = places_of(of_wire, true_names)
    names = names_of(ticks)
    protection, rules = rig.protection_rows()
    own = RigArrays(
        states=of_wire.row,
        constants=derived.copy(),
        cells=cells,
        load=load,
        plan=plan_of(device.stepping, period_s),
        sample_period_s=period_s,
        amplifier_resolution_v=device.spool.bench["amplifier_resolution_v"],
        rules=rules,
        protection=protection,
        noise=noise,
        air=air_of(air, device, wire, samples),
        readings=device.instruments.readings,
        scales=device.instruments.scales,
        places=places,
        true=np.empty((samples, places.size)),
        true_displacement_m=np.empty(samples),
        held_m=np.zeros(1),
        shown=np.empty((samples, len(names))),
    )
    functions = (callback(ticks.estimator.function, 4), callback(ticks.controller.function, 4))
    arrays = arrays_of(own, ticks, elapsed_s, targets)
    ended, complete = run_loop(*functions, arrays, first_drive_v)
    columns = dict(zip(names, np.ascontiguousarray(own.shown.T), strict=True))
    controller = ticks.controller._replace(state=arrays.controller_state)
    next_drive_v = float(arrays.controller_answer[0])
    found = CompiledRun(CompiledLoopEnd(ended), complete, columns, own.true, controller, next_drive_v)
    run = with_endpoint(found, own, device)
    if run.ended is CompiledLoopEnd.DONE:
        after = ends_after(run)
        if after is not None and after < samples:
            until = elapsed_s[:after], targets[:, :after]
            return run_compiled(rig, ticks, *until, first_drive_v, true_names, state=state)
        drive_v = float(columns["drive_voltage_v"][-1])
        rig.adopt_compiled_samples(own.protection, float(columns["time_s"][-1]))
        wire.adopt_compiled_state(own.states, own.constants)
        device.adopt(drive_v, generator, air, float(own.held_m[0]))
    return run


def run_known_drive(rig: GuardedRig, drives_v: FloatArray, true_names: Sequence[str] = ()) -> CompiledRun:
    """Hold each drive for a sample; for the rest as :func:`run_compiled`, without the columns of ticks."""
    schedule = CompiledTick(scheduled_drive, drives_v, np.zeros(1))
    ticks = LoopTicks(CompiledTick(no_estimate, np.zeros(1), np.zeros(1)), schedule, (), ())
    targets = np.zeros((2, drives_v.size))
    return run_compiled(rig, ticks, targets[0], targets, float(drives_v[0]), true_names)


def places_of(state: WireState, names: Sequence[str]) -> IntArray:
    """Return the places of fields among the plain numbers of a wire's state."""
    fields = state.row.dtype.fields
    assert fields is not None  # a row is a record
    return np.array([fields[name][1] // state.numbers.itemsize for name in names], dtype=np.int64)


def arrays_of(rig: RigArrays, ticks: LoopTicks, elapsed_s: FloatArray, targets: FloatArray) -> LoopArrays:
    """Return the arrays of a loop; those that it changes are copies."""
    estimator, controller = ticks.estimator, ticks.controller
    return LoopArrays(
        rig=rig,
        elapsed_s=elapsed_s,
        targets=targets,
        estimator_constants=estimator.constants,
        estimator_state=estimator.state.copy(),
        estimator_answer=np.zeros(len(ESTIMATOR_ANSWERS) + len(ticks.estimator_columns)),
        wire_places=wire_places(ticks.estimator_columns),
        controller_constants=controller.constants,
        controller_state=controller.state.copy(),
        controller_answer=np.zeros(len(CONTROLLER_ANSWERS) + len(ticks.controller_columns)),
    )


def wire_places(columns: tuple[str, ...]) -> IntArray:
    """Return where in an estimator's answer the numbers of a ``WireEstimate`` are; -1 for those that it has not."""
    first = len(ESTIMATOR_ANSWERS)
    places = [first + columns.index(name) if name in columns else -1 for name in WireEstimate._fields]
    return np.array(places, dtype=np.int64)


def air_of(model: AirModel | None, device: SimulatedDevice, wire: OneWire, samples: int) -> FloatArray:
    """Return the air's temperature [K] and surface times convection factor [m2], (n_samples, 2); no rows if still.

    The air is drawn here as a rig draws it from sample to sample: at their beginnings.
    """
    if model is None:
        return np.empty((0, 2))
    period_s, ambient_k = device.facts.sample_period_s, device.spool.bench["ambient_temperature_k"]
    began_s = [wire.time_s, *sample_times_s(wire, period_s, samples - 1).tolist()]
    drawn = [model.after(time_s, period_s) for time_s in began_s]
    return np.array([(ambient_k + air.warmer_k, wire.surface_factor_m2(air.convection_ratio)) for air in drawn])


def names_of(ticks: LoopTicks) -> tuple[str, ...]:
    """Return the names of what a loop shows, in their order."""
    return (
        *RIG_COLUMNS,
        *ticks.estimator_columns,
        "target",
        "estimated",
        "estimate_std",
        "valid",
        *ticks.controller_columns,
    )


def with_endpoint(run: CompiledRun, rig: RigArrays, device: SimulatedDevice) -> CompiledRun:
    """Return a run with the readings of the instruments at a finger's endpoint, if there is a finger."""
    tendon, moved_m = device.mechanism.tendon, rig.true_displacement_m
    if tendon is None:
        return run
    beyond = moved_m[: run.samples] + tendon.start_m - tendon.slack_m > tendon.curve.tendon_travel_m[-1]
    if beyond.any():  # the rig ends the run there
        return run._replace(ended=CompiledLoopEnd.BEYOND_FINGER, samples=int(np.argmax(beyond)))
    pull_n = tendon.endpoint_force_n(moved_m)
    displacement_noise_m, force_noise_n = device.instruments.endpoint_noise
    there = run.columns | {
        "endpoint_displacement_m": tendon.endpoint_m(moved_m, pull_n) + displacement_noise_m * rig.noise[:, -2],
        "endpoint_force_n": pull_n + force_noise_n * rig.noise[:, -1],
    }
    own = (*ELECTRICAL_COLUMNS, *device.facts.reference_columns)
    return run._replace(columns={name: there[name] for name in own} | run.columns)
