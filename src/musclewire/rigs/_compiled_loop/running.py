"""A closed loop of a simulated rig in compiled code: what of the rig goes in, and the columns that come out."""

from __future__ import annotations

from copy import deepcopy
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from musclewire.arrays import FloatArray
from musclewire.compiled import callback
from musclewire.controllers import State, packed_limits, packed_memory, protection_table
from musclewire.errors import CallerError, NumericsError
from musclewire.rigs._air import AirModel
from musclewire.rigs._compiled_loop.kernel import BENCH, RIG_COLUMNS, CompiledLoopEnd, LoopArrays, RigArrays, run_loop
from musclewire.rigs._compiled_loop.one_wire import sample_times_s, wire_arrays
from musclewire.rigs._guarded import GuardedRig
from musclewire.rigs._simulated import SimulatedDevice, SimulatedInside
from musclewire.signals import CONTROLLER_ANSWERS, ELECTRICAL_COLUMNS, ESTIMATOR_ANSWERS, CompiledTick
from musclewire.wire import OneWire

__all__ = [
    "CompiledRun",
    "LoopTicks",
    "LoopTargets",
    "columns_of",
    "inside_of",
    "require_same_clock",
    "rig_arrays",
    "run_compiled",
    "times_on_rig_s",
    "uncompiled",
    "with_endpoint",
]


class LoopTicks(NamedTuple):
    """The ticks of a loop, and the names of the columns that each of them records."""

    estimator: CompiledTick
    controller: CompiledTick
    estimator_columns: tuple[str, ...]
    controller_columns: tuple[str, ...]


class CompiledRun(NamedTuple):
    """How a compiled loop ended, how many samples are complete, and the columns of the rig, ticks and targets.

    ``friction_held_m`` is by how much friction held the connector ahead of the slack wire at most, ``step_error_k`` the
    largest estimated error of a step in temperature [K].
    """

    ended: CompiledLoopEnd
    samples: int
    columns: dict[str, FloatArray]
    friction_held_m: float
    step_error_k: float


def uncompiled(rig: GuardedRig) -> str:
    """Return what of a rig has no compiled form, in words; "" for a rig whose loop can be compiled."""
    device = rig.device
    if not isinstance(device, SimulatedDevice):
        return "the rig is not simulated"
    inside = device.inside()
    if inside.paced:
        return "the rig is paced by the machine's clock"
    if inside.faulty:
        return "the rig file lists faults"
    if inside.pulsed:
        return "the rig heats by pulse width"
    if not isinstance(inside.wires, OneWire):
        return "the rig has two wires"
    if rig.protection.state is not State.ARMED:
        return "the rig is being driven, or has failed"
    return ""


def inside_of(rig: GuardedRig) -> tuple[SimulatedInside, OneWire]:
    """Return the parts of a rig whose loop can be compiled, and its wire. Raises CallerError for another rig."""
    reason = uncompiled(rig)
    if reason:
        raise CallerError(f"this loop has no compiled form, because {reason}: run it in Python (--in-python)")
    assert isinstance(rig.device, SimulatedDevice)
    inside = rig.device.inside()
    assert isinstance(inside.wires, OneWire)
    return inside, inside.wires


def times_on_rig_s(rig: GuardedRig, samples: int) -> FloatArray:
    """Return the times of a rig's next samples on its clock [s], (n_samples,), as its steps will add them up."""
    inside, wire = inside_of(rig)
    return sample_times_s(wire, inside.bench["sample_period_s"], samples)


class LoopTargets(NamedTuple):
    """What a loop follows, and the times of its samples on the rig's clock [s], (n_samples,).

    ``values``, (2, n_samples), are those that held while each sample was taken and those that hold after it.
    """

    times_s: FloatArray
    values: FloatArray


def run_compiled(rig: GuardedRig, ticks: LoopTicks, targets: LoopTargets, first_drive_v: float) -> CompiledRun:
    """Run a closed loop from the present state of a rig, which itself is left as it is.

    The columns are those of the loop in Python, to the bit. The interpreter is free meanwhile: loops of several rigs
    run in threads. Raises CallerError for a rig whose loop has no compiled form.
    """
    inside, _ = inside_of(rig)
    noise, _ = inside.instruments.noise_ahead(targets.times_s.size)
    n_ticks = len(ticks.estimator_columns) + 3 + len(ticks.controller_columns)
    own = rig_arrays(rig, targets.times_s, noise, deepcopy(inside.air), n_ticks)
    arrays = arrays_of(own, ticks, targets.values)
    functions = (callback(ticks.estimator.function, 4), callback(ticks.controller.function, 4))
    ended, complete = run_loop(*functions, arrays, first_drive_v)
    require_same_clock(CompiledLoopEnd(ended), own)
    held_m = float(own.slack_m[:complete].max(initial=0.0))
    error_k = float(own.wire.states[0]["step_error_k"])
    run = CompiledRun(CompiledLoopEnd(ended), complete, columns_of(own.shown, names_of(ticks)), held_m, error_k)
    return with_endpoint(run, own.true_displacement_m, inside, noise)


def arrays_of(rig: RigArrays, ticks: LoopTicks, targets: FloatArray) -> LoopArrays:
    """Return the arrays of a loop; those that it changes are copies."""
    estimator, controller = ticks.estimator, ticks.controller
    return LoopArrays(
        rig=rig,
        targets=targets,
        estimator_constants=estimator.constants,
        estimator_state=estimator.state.copy(),
        estimator_answer=np.zeros(len(ESTIMATOR_ANSWERS) + len(ticks.estimator_columns)),
        controller_constants=controller.constants,
        controller_state=controller.state.copy(),
        controller_answer=np.zeros(len(CONTROLLER_ANSWERS) + len(ticks.controller_columns)),
    )


def rig_arrays(
    rig: GuardedRig, times_s: FloatArray, noise: FloatArray, air: AirModel | None, n_ticks: int = 0
) -> RigArrays:
    """Return the arrays of a rig at its present state, for samples that end at these times.

    ``air`` is a model of the air of the run's own, None for still air; ``n_ticks`` numbers of ticks are shown after the
    rig's. What the run changes is a copy.
    """
    inside, wire = inside_of(rig)
    samples = times_s.size
    return RigArrays(
        wire=wire_arrays(wire, inside.stepping, inside.bench["sample_period_s"]),
        times_s=times_s,
        bench=packed_bench(inside),
        limits=packed_limits(rig.protection_limits),
        memory=packed_memory(rig.protection),
        noise=noise,
        air=air_of(air, inside, wire, times_s),
        readings=inside.instruments.readings,
        scales=inside.instruments.scales,
        true_displacement_m=np.empty(samples),
        slack_m=np.empty(samples),
        shown=np.empty((samples, len(RIG_COLUMNS) + n_ticks)),
    )


def packed_bench(inside: SimulatedInside) -> NDArray[np.void]:
    """Return the numbers of the bench that the loop reads."""
    known = {**inside.bench, "reading_period_s": protection_table().reading_period_s}
    return np.array([tuple(known[name] for name in BENCH.names or ())], BENCH)


def air_of(model: AirModel | None, inside: SimulatedInside, wire: OneWire, times_s: FloatArray) -> FloatArray:
    """Return the air's temperature [K] and surface times convection factor [m2], (n_samples, 2); no rows if still.

    The air is drawn here as a rig draws it from sample to sample: at their beginnings.
    """
    if model is None:
        return np.empty((0, 2))
    period_s, ambient_k = inside.bench["sample_period_s"], inside.bench["ambient_temperature_k"]
    began_s = [wire.time_s, *times_s[:-1].tolist()]
    drawn = [model.after(time_s, period_s) for time_s in began_s]
    return np.array([(ambient_k + air.warmer_k, wire.surface_factor_m2(air.convection_ratio)) for air in drawn])


def names_of(ticks: LoopTicks) -> tuple[str, ...]:
    """Return the names of what a loop shows, in their order."""
    return (*RIG_COLUMNS, *ticks.estimator_columns, "target", "estimated", "valid", *ticks.controller_columns)


def columns_of(shown: FloatArray, names: tuple[str, ...]) -> dict[str, FloatArray]:
    """Return the columns that a run has written, by name."""
    return dict(zip(names, np.ascontiguousarray(shown.T), strict=True))


def require_same_clock(ended: CompiledLoopEnd, arrays: RigArrays) -> None:
    """Raise NumericsError if a run that reached its end did so at another time than the rig will."""
    if ended is CompiledLoopEnd.DONE and arrays.wire.states[0]["time_s"] != arrays.times_s[-1]:
        raise NumericsError("the compiled loop's clock differs from the rig's: report it with the rig file")


def with_endpoint(
    run: CompiledRun, true_displacement_m: FloatArray, inside: SimulatedInside, noise: FloatArray
) -> CompiledRun:
    """Return a run with the readings of the instruments at a finger's endpoint, if there is a finger."""
    tendon, moved_m = inside.mechanism.tendon, true_displacement_m
    if tendon is None:
        return run
    beyond = moved_m[: run.samples] + tendon.start_m - tendon.slack_m > tendon.curve.tendon_travel_m[-1]
    if beyond.any():  # the rig ends the run there
        return run._replace(ended=CompiledLoopEnd.BEYOND_FINGER, samples=int(np.argmax(beyond)))
    pull_n = tendon.endpoint_force_n(moved_m)
    displacement_noise_m, force_noise_n = inside.instruments.endpoint_noise
    there = run.columns | {
        "endpoint_displacement_m": tendon.endpoint_m(moved_m, pull_n) + displacement_noise_m * noise[:, -2],
        "endpoint_force_n": pull_n + force_noise_n * noise[:, -1],
    }
    own = (*ELECTRICAL_COLUMNS, *inside.reference_columns)
    return run._replace(columns={name: there[name] for name in own} | run.columns)
