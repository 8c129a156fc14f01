"""Many simulated wires as one Gymnasium vector environment: one call a step, in place on arrays, with protection."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from musclewire.arrays import FloatArray
from musclewire.compiled import callback
from musclewire.controllers import (
    Event,
    Protection,
    ProtectionLimits,
    protection_table,
)
from musclewire.errors import CallerError, NumericsError
from musclewire.extras.interfaces._environments.episodes import Episode, episode_from
from musclewire.extras.interfaces._environments.kernels import (
    ENDS,
    FACTS,
    MEMORY,
    draw_levels,
    drive_lanes,
    estimate_lanes,
    judge_lanes,
    read_lanes,
)
from musclewire.extras.interfaces._environments.spaces import (
    action_space,
    checked_actions,
    no_options,
    observation_space,
    strain_model,
)
from musclewire.extras.interfaces._simulated_wire import SimulatedWire, simulated_wire
from musclewire.rigs import RigConfiguration
from musclewire.sensing import ESTIMATORS, EstimatorSetup, SensingModel, default_estimator
from musclewire.signals import ESTIMATOR_ANSWERS, declared_tick
from musclewire.wire import WireBatch, fixed_steps

# Longest step of the simulation: with both bounds a jump of the drive errs by hundredths of a kelvin
# (benchmarks/vector_environment.py).
MAX_STEP_S = 0.025
MAX_STEP_FRACTION = 0.05  # of the quickest wire's time constant

Rig = str | Path | RigConfiguration
Mask = NDArray[np.bool_]
Step = tuple[FloatArray, FloatArray, Mask, Mask, dict[str, Any]]


class WireVectorEnv(VectorEnv[FloatArray, FloatArray, Any]):
    """Many wires, each as in :class:`WireEnv` and with the same observation, action and reward.

    A wire whose episode has ended is at rest and cold at the next step, which ignores its action and returns the first
    observation of its next episode, with a reward of 0 (Gymnasium's next-step autoreset). Noise and targets depend on
    the seed, the wire's number, its episode and its sample: not on the number of wires, nor on threads. They are not
    those of :class:`WireEnv` with the same seed.

    Parameters
    ----------
    num_envs
        Number of wires.
    rig
        A simulated rig, as in :class:`WireEnv`, or a sequence of rigs, which the wires take in turn. Each has one wire,
        still air, no faults, and samples of at least 10 ms; all have the same sample period.
    episode
        "staircase", "random", an :class:`Episode`, or its numbers by name.
    model
        Model of the wire, or the path of its file; adds the estimator's strain to the observation. None adds nothing.
    estimator
        Name of the estimator that uses the model; that of a closed loop with it if None.
    **settings
        Numbers of wire and bench by name, as ``mw.open_rig`` takes them.

    Raises
    ------
    CallerError
        For a rig that this environment cannot simulate, an unknown name, a model that does not estimate strain, and an
        estimator without a compiled tick.
    """

    # As the base class declares it, whose makers read it of the class.
    metadata: dict[str, Any] = {"render_modes": [], "autoreset_mode": AutoresetMode.NEXT_STEP}  # noqa: RUF012

    def __init__(
        self,
        num_envs: int = 1,
        rig: Rig | Sequence[Rig] = "simulated",
        *,
        episode: Episode | str | dict[str, Any] = "staircase",
        model: SensingModel | str | Path | None = None,
        estimator: str | None = None,
        **settings: float | str,
    ) -> None:
        """Make the wires; they are cold."""
        if num_envs < 1:
            raise CallerError(f"an environment of {num_envs} wires: give at least 1")
        rigs = [rig] if isinstance(rig, str | Path | RigConfiguration) else list(rig)
        wires = [simulated_wire(one, **settings) for one in rigs]
        period_s = checked_period_s(wires)
        self.num_envs = num_envs
        self._episode = episode_from(episode)
        known = strain_model(model)
        lanes = [wires[lane % len(wires)] for lane in range(num_envs)]
        self._step_s, self._period_s = step_s_of(wires, period_s), period_s
        self._wires = WireBatch([wire.constants for wire in lanes], stepping=fixed_steps(self._step_s))
        own = np.arange(num_envs) % len(wires)
        self._estimating = None if known is None else LaneEstimators(known, estimator, wires, own)
        self._facts = np.concatenate([facts_of(wire) for wire in wires])[own]
        protections = [Protection(wire.limits) for wire in wires]
        self._rules = np.concatenate([protection.rules for protection in protections])[own]
        self._armed = np.concatenate([protection.row for protection in protections])[own]
        self._protections = self._armed.copy()
        self._memory = np.zeros(num_envs, MEMORY)
        self._targets = np.zeros((num_envs, self._episode.levels))
        self._drive_v = np.zeros(num_envs)
        self._seed, self._level_of_sample = 0, self._episode.level_of_sample(period_s)
        self.single_action_space = action_space()
        self.action_space = batch_space(self.single_action_space, num_envs)
        widest = ProtectionLimits(*map(max, zip(*(wire.limits for wire in wires), strict=True)))
        self.single_observation_space = observation_space(widest, self._episode, known)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self._observed = np.zeros((num_envs, *(self.single_observation_space.shape or ())))

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[FloatArray, dict[str, Any]]:
        """Let all wires cool, draw new targets, and take a first sample at the sense voltage.

        Parameters
        ----------
        seed
            Seed of targets and noise of all wires; None continues the random numbers of the last one.
        options
            None are known.

        Returns
        -------
        The first observations, (num_envs, n_observed), and no information.

        Raises
        ------
        CallerError
            For any option.
        """
        no_options(options)
        super().reset(seed=seed, options=options)
        self._seed = int(self.np_random.integers(2**63 - 1))
        self._memory["ended"], self._memory["episode"] = 1, -1
        self._observed[:] = 0.0
        self._take_sample(np.zeros(self.num_envs))
        return self._observed.copy(), {}

    def step(self, actions: FloatArray) -> Step:
        """Hold a drive at each wire for one sample.

        Parameters
        ----------
        actions
            The drives, (num_envs, 1), as in :meth:`WireEnv.step`.

        Returns
        -------
        Observations, rewards, which episodes the protection has ended, which have come to the end of their time, and
        information: ``measured_strain`` of each wire, and ``event`` of those that the protection has switched off.

        Raises
        ------
        CallerError
            For actions of another shape, or that are not finite, and before a reset.
        NumericsError
            When an episode has ended, if steps of the simulation were too long for what a wire did.
        """
        if self._np_random is None:
            raise CallerError("no episode has begun: call reset")
        ends = self._take_sample(checked_actions(actions, (self.num_envs, 1))[:, 0])
        infos: dict[str, Any] = {"measured_strain": ends["strain"]}
        terminated = ends["event"] != 0
        if terminated.any():
            names = [Event(number).name.lower() if number else None for number in ends["event"].tolist()]
            infos |= {"event": np.array(names, dtype=object), "_event": terminated.copy()}
        return self._observed.copy(), ends["reward"], terminated, ends["truncated"], infos

    def _take_sample(self, actions: FloatArray) -> NDArray[np.void]:
        """Advance all wires by a sample, those whose episode has ended from rest; return how it ends."""
        ended = self._memory["ended"] != 0
        if ended.any():
            self._restart(ended)
        lanes = self._rules, self._protections, self._memory
        drive_lanes(self._facts, *lanes, actions, self._drive_v)
        means = np.stack(self._wires.advance(self._drive_v, self._period_s)[:3])
        ends = np.zeros(self.num_envs, ENDS)
        read_lanes(self._facts, *lanes, self._seed, means, ends)
        judge_lanes(self._rules, self._memory, self._targets, self._level_of_sample, ends, self._observed)
        if self._estimating is not None:
            self._estimating.observe(self._memory["sample"] * self._period_s, self._drive_v, ends, self._observed)
        return ends

    def _restart(self, lanes: Mask) -> None:
        """Begin the next episode of some wires: cold, with new targets."""
        self._require_resolved()
        self._wires.rest(lanes)
        self._protections[lanes] = self._armed[lanes]
        self._memory["sample"][lanes] = 0
        self._memory["episode"][lanes] += 1
        if self._estimating is not None:
            self._estimating.restart(lanes)
        draws = np.empty((int(lanes.sum()), self._episode.levels))
        for row, lane in enumerate(np.flatnonzero(lanes).tolist()):
            draw_levels(self._seed, lane, int(self._memory["episode"][lane]), draws[row])
        self._targets[lanes] = self._episode.drawn(draws)

    def _require_resolved(self) -> None:
        """Raise NumericsError if a step of any wire since its rest was unsolved, or too long for what happened."""
        try:
            self._wires.require_resolved(self._period_s)
        except NumericsError as error:
            raise NumericsError(
                f"steps of {1e3 * self._step_s:.3g} ms do not resolve what a wire of this environment does: give it a "
                f"time_step_s that is a fraction of that ({str(error).partition(';')[0]})"
            ) from None


class LaneEstimators:
    """One estimator for each lane: the compiled tick of all, with constants and state of each."""

    def __init__(
        self, model: SensingModel, name: str | None, wires: Sequence[SimulatedWire], own: NDArray[np.intp]
    ) -> None:
        """Make one for each rig, of which lane ``i`` has that of ``own[i]``. Raises CallerError without a tick."""
        chosen = name or default_estimator(model)[0]
        setups = [EstimatorSetup(model, wire.limits.shunt_resistance_ohm, wire.sample_period_s) for wire in wires]
        estimators = [ESTIMATORS.find(chosen)(setup) for setup in setups]
        ticks = [tick for tick in map(declared_tick, estimators) if tick is not None]
        if len(ticks) < len(wires):
            raise CallerError(f"the estimator {chosen} has no compiled tick, which many wires need: take WireEnv")
        self._answer = np.empty(len(ESTIMATOR_ANSWERS) + len(estimators[0].columns))
        self._tick = callback(ticks[0].function, 4)
        self._constants = np.stack([tick.constants for tick in ticks])[own]
        self._first_states = np.stack([tick.state for tick in ticks])[own]
        self._states = self._first_states.copy()

    def restart(self, lanes: Mask) -> None:
        """Begin an episode in some lanes."""
        self._states[lanes] = self._first_states[lanes]

    def observe(self, time_s: FloatArray, drive_v: FloatArray, ends: NDArray[np.void], observed: FloatArray) -> None:
        """Observe the strain in each lane that is still driven. Raises NumericsError if the estimator failed."""
        lanes = self._constants, self._states, time_s, drive_v, ends
        failed = estimate_lanes(self._tick, *lanes, self._answer, observed)
        if failed >= 0:
            raise NumericsError(f"the estimator failed at wire {failed}: WireEnv with the same drives says why")


def step_s_of(wires: Sequence[SimulatedWire], period_s: float) -> float:
    """Return the fixed step of all wires [s]: that of the first one's bench, or what suits the quickest wire."""
    quickest_s = min(wire.limits.heat.lag_s for wire in wires)
    steps = math.ceil(period_s / min(MAX_STEP_S, MAX_STEP_FRACTION * quickest_s) - 1e-9)
    return wires[0].stepping.fixed_s or period_s / steps


def checked_period_s(wires: Sequence[SimulatedWire]) -> float:
    """Return the sample period of all rigs. Raises CallerError for rigs that cannot be simulated side by side."""
    if not all(wire.undisturbed for wire in wires):
        raise CallerError("a rig with [[fault]] or moving air: the vector environment has neither, take WireEnv")
    periods = {wire.sample_period_s for wire in wires}
    if len(periods) != 1:
        raise CallerError(f"rigs with sample periods of {sorted(periods)} s: give rigs of one period")
    (period_s,) = periods
    shortest_s = protection_table().reading_period_s
    if period_s < shortest_s:
        raise CallerError(
            f"a sample period of {period_s:g} s: the protection averages readings below {shortest_s:g} s, and this "
            "environment does not: give a longer one"
        )
    return period_s


def facts_of(wire: SimulatedWire) -> NDArray[np.void]:
    """Return the record of a lane's rig, (1,)."""
    facts = np.zeros(1, FACTS)
    names = ("amplifier_resolution_v", "acquisition_noise_v", "acquisition_readings", "displacement_noise_m")
    for name in ("sample_period_s", *names):
        facts[name] = wire.bench[name]
    facts["leg_length_m"] = wire.constants.leg_length_m
    facts["acquisition_step_v"] = 2.0 * wire.bench["acquisition_range_v"] / 2.0 ** wire.bench["acquisition_bits"]
    return facts
