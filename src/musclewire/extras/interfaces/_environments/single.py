"""One simulated rig as a Gymnasium environment: the rig itself, with its instruments, load, air and protection."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import gymnasium
import numpy as np

from musclewire.arrays import FloatArray
from musclewire.errors import CallerError, RigError
from musclewire.extras.interfaces._environments.episodes import MAX_RESISTANCE_FACTOR, PERCENT, Episode, episode_from
from musclewire.extras.interfaces._environments.spaces import (
    action_space,
    checked_actions,
    no_options,
    observation_space,
    strain_model,
)
from musclewire.physics import wire_resistance
from musclewire.rigs import GuardedRig, ProtectionTripError, RigConfiguration, open_rig, simulated_configuration
from musclewire.sensing import ESTIMATORS, EstimatorSetup, SensingModel, default_estimator
from musclewire.signals import Drive, RawSample, wire_sample


class WireEnv(gymnasium.Env[FloatArray, FloatArray]):
    """A wire on a simulated rig that is to follow a strain, by its voltages.

    An observation is what a real rig gives: wire voltage [V], shunt voltage [V], resistance by Eq. 1 [ohm], drive [V]
    and the target of the next sample (strain as a fraction); with a model also the estimator's strain. The true strain,
    temperature and phases are not among them. An action is the next drive, -1 for the sense voltage and 1 for the
    maximum voltage of the rig.

    The reward of a sample is ``-100 |target - strain|``, the error in percent strain, with the strain that the rig's
    displacement sensor measured; ``info["measured_strain"]`` is that strain, for evaluation. If the protection switches
    off, the episode is terminated, the event is ``info["event"]``, and the reward is that of a wire that stays at zero
    strain, below the highest target, until the end of the episode.

    Parameters
    ----------
    rig
        "simulated", the name of another simulated rig, the path of its file, or a configuration.
    episode
        "staircase", "random", an :class:`Episode`, or its numbers by name.
    model
        Model of the wire, or the path of its file; adds the estimator's strain to the observation. None adds nothing.
    estimator
        Name of the estimator that uses the model; that of a closed loop with it if None.
    render_mode
        None: there is nothing to render.
    settings
        Numbers of wire and bench by name, as ``mw.open_rig`` takes them.

    Raises
    ------
    CallerError
        For a rig that is not simulated, an unknown name, and a model that does not estimate strain.
    """

    # As the base class declares it, whose makers read it of the class.
    metadata: dict[str, Any] = {"render_modes": []}  # noqa: RUF012

    def __init__(
        self,
        rig: str | Path | RigConfiguration = "simulated",
        *,
        episode: Episode | str | dict[str, Any] = "staircase",
        model: SensingModel | str | Path | None = None,
        estimator: str | None = None,
        render_mode: str | None = None,
        **settings: float | str,
    ) -> None:
        """Open the rig once, to know its limits."""
        self.render_mode = render_mode
        self._configuration, _ = simulated_configuration(rig)
        self._settings: dict[str, Any] = settings
        self._episode, self._model = episode_from(episode), strain_model(model)
        self._rig, self._running = self._opened(0), False
        if self._model is not None:
            self._estimator = ESTIMATORS.find(estimator or default_estimator(self._model)[0])(
                EstimatorSetup(self._model, self._rig.shunt_resistance_ohm, self._rig.sample_period_s)
            )
        self._limits = self._rig.protection_limits
        self._level_of_sample = self._episode.level_of_sample(self._rig.sample_period_s)
        self.action_space = action_space()
        space = observation_space(self._limits, self._episode, self._model)
        self.observation_space, self._shape = space, space.shape

    def _opened(self, seed: int) -> GuardedRig:
        return open_rig(self._configuration, seed=seed, **self._settings)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[FloatArray, dict[str, Any]]:
        """Let the wire cool, draw new targets, and take a first sample at the sense voltage; no options are known."""
        no_options(options)
        super().reset(seed=seed, options=options)
        self._rig.close()
        self._running = True
        self._rig = self._opened(int(self.np_random.integers(2**31)))
        self._targets = self._episode.drawn(self.np_random.random(self._episode.levels))
        self._sample = 0
        if self._model is not None:
            self._sensed = self._estimator.start()
        self._observed = np.zeros(self._shape)
        self._observe(self._rig.exchange(Drive(self._rig.sense_voltage_v)))
        return self._observed.copy(), {}

    def step(self, action: FloatArray) -> tuple[FloatArray, float, bool, bool, dict[str, Any]]:
        """Hold a drive for one sample; CallerError before a reset, and after the protection has switched off.

        The action is (1,): -1 for the sense voltage, 1 for the maximum voltage; finite numbers beyond count as these.
        """
        if not self._running:
            raise CallerError("this episode has not begun, or the protection has ended it: call reset")
        part = 0.5 * (float(np.clip(checked_actions(action, (1,))[0], -1.0, 1.0)) + 1.0)
        span_v = self._limits.maximum_voltage_v - self._limits.sense_voltage_v
        drive_v = min(self._limits.sense_voltage_v + part * span_v, self._limits.maximum_voltage_v)
        self._sample += 1
        last = self._level_of_sample.size - 1
        target = self._target_at(self._sample - 1)
        try:
            sample = self._rig.exchange(Drive(drive_v))
        except RigError as error:
            self._running = False
            self._observed[3:5] = 0.0, self._target_at(self._sample)
            reward = -PERCENT * self._targets.max() * (last - self._sample + 1)
            event = error.event.name.lower() if isinstance(error, ProtectionTripError) else str(error)
            return self._observed.copy(), float(reward), True, False, {"event": event}
        self._observe(sample)
        assert sample.displacement_m is not None  # every simulated rig has this sensor
        strain = sample.displacement_m / self._rig.leg_length_m
        reward = -PERCENT * abs(target - strain)
        return self._observed.copy(), float(reward), False, self._sample >= last, {"measured_strain": strain}

    def close(self) -> None:
        """Switch the rig's drive off."""
        self._running = False
        self._rig.close()

    def _target_at(self, sample: int) -> float:
        """Return the target that is asked for in a sample, counted from the first after the reset."""
        return float(self._targets[self._level_of_sample[sample]])

    def _observe(self, sample: RawSample) -> None:
        """Write what a sample shows, and the target of the next one, into the observation."""
        reading = wire_resistance(sample.wire_voltage_v, sample.shunt_voltage_v, self._limits.shunt_resistance_ohm)
        seen = MAX_RESISTANCE_FACTOR * self._limits.resistance_high_ohm
        self._observed[0], self._observed[1] = sample.wire_voltage_v, sample.shunt_voltage_v
        self._observed[2] = min(max(reading.resistance_ohm, 0.0), seen)
        self._observed[3], self._observed[4] = sample.drive_voltage_v, self._target_at(self._sample)
        if self._model is not None:
            estimate, self._sensed, _ = self._estimator.step(self._sensed, wire_sample(sample))
            self._observed[5] = estimate.value
