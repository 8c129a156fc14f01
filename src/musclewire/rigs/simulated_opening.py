"""Opening of a simulated rig: from its rig file to the device."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from musclewire.errors import CallerError
from musclewire.parameters.library import bench_known_with, load_alloy, load_bench, load_wire
from musclewire.parameters.parameter_groups import Alloy, Bench, Wire
from musclewire.parameters.seeds import require_seed
from musclewire.rigs.kinds import DeviceKind
from musclewire.rigs.pulse_width import PulseWidth, sampling_problem
from musclewire.rigs.simulated import SimulatedDevice
from musclewire.rigs.simulated_building import Spool
from musclewire.rigs.simulated_configuration import RigConfiguration, changed_group, with_settings
from musclewire.rigs.simulated_pwm import PulsedDevice

__all__ = ["SIMULATED", "device_of", "open_simulated", "parameters_of"]


def open_simulated(
    configuration: RigConfiguration,
    where: str,
    wire: str | None,
    bench: str | None,
    seed: int | None,
    real_time: bool,
    settings: Mapping[str, float | str],
) -> SimulatedDevice:
    """Return the open simulated rig of a rig file, changed as ``open_rig`` says."""
    drawn_from = require_seed(configuration.seed if seed is None else seed, f"{where}: seed")
    parameters = parameters_of(configuration, where, wire, bench, settings)
    return device_of(configuration, where, parameters, seed=drawn_from, real_time=real_time, settings=settings)


def parameters_of(
    configuration: RigConfiguration,
    where: str,
    wire: str | None,
    bench: str | None,
    settings: Mapping[str, float | str],
) -> tuple[Alloy, Wire, Bench]:
    """Return alloy, wire and bench of a rig file with all settings. Raises CallerError for wrong ones."""
    name = wire or configuration.wire
    named = load_wire(name)
    around = load_bench(bench or configuration.bench)
    if bench is None and "bench" not in configuration.model_fields_set:
        around = changed_group(around, bench_known_with(name), f"wire file {name}")
    given = {**configuration.all_settings(), **settings}
    chosen, around = with_settings(named, around, given, where)
    return load_alloy(chosen.alloy), chosen, around


def device_of(
    configuration: RigConfiguration,
    where: str,
    parameters: tuple[Alloy, Wire, Bench],
    *,
    seed: int,
    real_time: bool,
    settings: Mapping[str, float | str],
) -> SimulatedDevice:
    """Return the simulated device of a rig file with the numbers of an alloy, a wire and a bench.

    ``settings`` are those that the numbers already have; they are only checked. Raises CallerError for one that the
    rig's load leaves without effect.
    """
    alloy, chosen, around = parameters
    given = {**configuration.all_settings(), **settings}
    if configuration.load and "spring_stiffness_n_per_m" in given:
        raise CallerError(
            f"{where}: the setting 'spring_stiffness_n_per_m' belongs to the bench's spring, and [[load]] replaces it: "
            "give a part 'spring' with a stiffness"
        )
    device = device_with(
        configuration.pwm,
        Spool(chosen, alloy, around, configuration.new_wire),
        parts=configuration.load,
        surroundings=configuration.surroundings,
        seed=seed,
        real_time=real_time,
        limits=configuration.limits.changed(),
        faults=configuration.fault,
    )
    if "pretension_n" in given and not device.has_stage:
        raise CallerError(
            f"{where}: the setting 'pretension_n' needs a stage, and this rig has none: the part 'weight' is the "
            "pretension"
        )
    return device


def device_with(pwm: PulseWidth | None, spool: Spool, **how: Any) -> SimulatedDevice:
    """Return the simulated device, with a steady drive or heated by pulses. Raises CallerError for useless readings."""
    if pwm is None:
        return SimulatedDevice(spool, **how)
    problem = sampling_problem(pwm, spool.bench.sense_voltage_v.value)
    if problem is not None and problem.useless:
        raise CallerError(f"[pwm] {problem.text}")
    return PulsedDevice(pwm, spool, **how)


def opened(configuration: RigConfiguration) -> SimulatedDevice:
    """Return the simulated device of a rig file without changes."""
    return open_simulated(configuration, "rig", None, None, None, False, {})


SIMULATED = DeviceKind(RigConfiguration, opened)
