"""The recordings that the checks need, each made once and only when asked for."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property

import numpy as np

from musclewire.controllers import Staircase
from musclewire.experiment import PAPER_CONTROLLER, ControlRun, characterize, control_compiled
from musclewire.extras.paper._reproduce.finger_runs import FingerRuns
from musclewire.extras.paper._reproduce.loops import CYCLES, SlowSineLoop, loop_on
from musclewire.extras.paper._reproduce.seedless_runs import SeedlessRuns
from musclewire.identify import IsobaricLoop, IsobarSummary, fit
from musclewire.parameters import load_bench, load_wire, read_published
from musclewire.rigs import RigConfiguration, open_rig
from musclewire.sensing import PAPER_ESTIMATOR, SensingModel

MAIN_WIRE = "paper-100um"
COLD_SAMPLES = 40


class RunCache:
    """Makes recordings on the simulated rig and keeps them; every rig is opened with the same seed."""

    def __init__(
        self, seed: int = 1, on_run: Callable[[], None] | None = None, seedless: SeedlessRuns | None = None
    ) -> None:
        """Make nothing yet; ``on_run`` is called after every run, ``seedless`` is shared with runs of other seeds."""
        self._seed = seed
        self._seedless = seedless or SeedlessRuns()
        self._on_run = on_run or (lambda: None)
        self._loops: dict[tuple[str, float, float | None, float | None], SlowSineLoop] = {}
        self._cold: dict[str, float] = {}
        self.finger = FingerRuns(seed, self._on_run)

    @property
    def seed(self) -> int:
        """The seed of every rig."""
        return self._seed

    def for_seed(self, seed: int) -> RunCache:
        """Return runs of another seed; what no seed changes is the same object."""
        return RunCache(seed, self._on_run, self._seedless)

    def loop(
        self,
        wire: str,
        pretension_n: float,
        *,
        amplitude_v: float | None = None,
        stiffness_n_per_m: float | None = None,
    ) -> SlowSineLoop:
        """Return the slow sine of a wire at a pretension, from a rig opened for it alone.

        Without ``amplitude_v`` it is the wire's own, without ``stiffness_n_per_m`` the bench's spring. Raises
        RecordingError if the recording shows no loop.
        """
        key = (wire, round(pretension_n, 6), amplitude_v, stiffness_n_per_m)
        if key not in self._loops:
            settings: dict[str, float | str] = {"pretension_n": pretension_n}
            if stiffness_n_per_m is not None:
                settings["spring_stiffness_n_per_m"] = stiffness_n_per_m
            with open_rig(RigConfiguration(wire=wire, seed=self._seed, settings=settings)) as rig:
                self._loops[key] = loop_on(rig, amplitude_v)
            self._on_run()
        return self._loops[key]

    def main_loop(self) -> SlowSineLoop:
        """Return the loop of Fig. 9: 100 um at 1.9 N, 3.2 V."""
        paper = read_published("lan_fan_2010")
        return self.loop(
            MAIN_WIRE, paper["loop_100um"]["pretension_n"], amplitude_v=float(paper["setup"]["amplitude_v"][0])
        )

    @cached_property
    def model(self) -> SensingModel:
        """The sixth-order model of the loop of Fig. 9."""
        return fit(self.main_loop().recording)

    @property
    def staircase(self) -> Staircase:
        """The paper's steps."""
        return self._seedless.staircase

    @cached_property
    def control_run(self) -> ControlRun:
        """The staircase of Fig. 11, on a rig that has just run the loop of Fig. 9."""
        pretension = read_published("lan_fan_2010")["loop_100um"]["pretension_n"]
        rig = open_rig("simulated", wire=MAIN_WIRE, seed=self._seed, pretension_n=pretension)
        model = fit(characterize(rig, cycles=CYCLES, minor_loop=False))
        run = control_compiled(rig, model, self.staircase, estimator=PAPER_ESTIMATOR, controller=PAPER_CONTROLLER)
        self._on_run()
        return run

    def cold_resistance_per_metre(self, wire: str) -> float:
        """Return ohm per metre of a cold wire by Eq. 1 at the sense voltage, each leg under its nominal force."""
        if wire not in self._cold:
            bench, spool = load_bench("paper").values(), load_wire(wire).values()
            pull_n = bench["legs"] * spool["nominal_force_n"]
            with open_rig("simulated", wire=wire, seed=self._seed, pretension_n=pull_n) as rig:
                samples = [rig.exchange(rig.sense_voltage_v) for _ in range(COLD_SAMPLES)]
            wire_voltage = np.mean([sample.wire_voltage_v for sample in samples])
            shunt_voltage = np.mean([sample.shunt_voltage_v for sample in samples])
            resistance_ohm = float(wire_voltage / shunt_voltage) * bench["shunt_resistance_ohm"]
            self._cold[wire] = resistance_ohm / bench["wire_length_m"]
        return self._cold[wire]

    def isobar(self, stress_mpa: float) -> IsobaricLoop:
        """Return the simulated loop at constant stress of the sample behind the published isobars."""
        return self._seedless.isobar(stress_mpa)

    def isobar_summary(self, stress_mpa: float) -> IsobarSummary:
        """Return stroke and temperatures of the simulated isobar."""
        return self._seedless.isobar_summary(stress_mpa)
