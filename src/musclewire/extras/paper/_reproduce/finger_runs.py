"""The runs on the finger of section IV, each made once."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import Final

from musclewire.controllers import Staircase, staircase
from musclewire.errors import RigError
from musclewire.experiment import PAPER_CONTROLLER, ControlRun, TendonZero, characterize, control_compiled, zero_tendon
from musclewire.extras.paper._reproduce.loops import CYCLES, SlowSineLoop, loop_on
from musclewire.identify import fit
from musclewire.parameters import load_wire, read_published
from musclewire.rigs import GuardedRig, open_rig, simulated_configuration
from musclewire.sensing import PAPER_ESTIMATOR, SensingModel
from musclewire.signals import RawSample

FINGER_RIG: Final = "finger"
# The assumed spool of the finger's wire, and the spool of section III.
FINGER_WIRE, COMMON_WIRE = "finger-100um", "paper-100um"
# Offset of the finger's stage when the search for its zero begins, as set by a careful hand.
STAGE_OFF_M = 40e-6


def pretension_n() -> float:
    """Return the pretension that the paper chose for the finger."""
    return float(read_published("lan_fan_2010")["displacement_gap"]["pretension_n"])


def staircase_of_fig18() -> Staircase:
    """Return the steps of Fig. 18, in metres."""
    printed = read_published("lan_fan_2010")["table3"]
    levels = printed["desired_displacement_mm"]
    return staircase(
        levels[0] / 1000.0, levels[-1] / 1000.0, printed["step_mm"] / 1000.0, hold_s=float(printed["step_s"])
    )


class FingerRuns:
    """Makes recordings on the rig "finger" and keeps them; every rig is opened with the same seed."""

    def __init__(self, seed: int, on_run: Callable[[], None]) -> None:
        """Make nothing yet; ``on_run`` is called after every run."""
        self._seed = seed
        self._on_run = on_run
        self._loops: dict[tuple[str, float], SlowSineLoop] = {}

    def open(self, wire: str = FINGER_WIRE, force_n: float | None = None) -> GuardedRig:
        """Open the rig with a wire at a pretension; another wire gets the voltages of this length."""
        own = load_wire(FINGER_WIRE).values()
        return open_rig(
            FINGER_RIG,
            wire=wire,
            seed=self._seed,
            pretension_n=pretension_n() if force_n is None else force_n,
            drive_amplitude_v=own["drive_amplitude_v"],
            maximum_voltage_v=own["maximum_voltage_v"],
        )

    def loop(self, force_n: float, wire: str = FINGER_WIRE) -> SlowSineLoop:
        """Return the slow sine at a pretension. Raises RecordingError if the recording shows no loop."""
        key = (wire, round(force_n, 6))
        if key not in self._loops:
            with self.open(wire, force_n) as rig:
                self._loops[key] = loop_on(rig)
            self._on_run()
        return self._loops[key]

    @cached_property
    def control_run(self) -> ControlRun:
        """The staircase of Fig. 18, on a rig that has just run its slow sine."""
        rig = self.open()
        model = fit(characterize(rig, cycles=CYCLES, minor_loop=False), quantity="displacement")
        run = control_compiled(rig, model, staircase_of_fig18(), estimator=PAPER_ESTIMATOR, controller=PAPER_CONTROLLER)
        self._on_run()
        return run

    @cached_property
    def model(self) -> SensingModel:
        """The sixth-order model of the loop at the chosen pretension."""
        return fit(self.loop(pretension_n()).recording, quantity="displacement")

    @cached_property
    def tendon_zero(self) -> TendonZero:
        """The search for the zero of Linear Stage 2, from a setting that is off."""
        with self.open() as rig:
            return zero_tendon(rig, start_slack_m=STAGE_OFF_M)

    @cached_property
    def initial_deflection_m(self) -> dict[bool, float]:
        """Displacement by laser of the cold endpoint against no pretension, with and without pretensioner."""
        return {kept: self._cold_endpoint_m(kept) for kept in (True, False)}

    def _cold_endpoint_m(self, with_pretensioner: bool) -> float:
        configuration, _ = simulated_configuration(FINGER_RIG)
        parts = [part for part in configuration.load if with_pretensioner or part.part != "pretensioner"]
        changed = configuration.model_copy(update={"load": parts, "seed": self._seed})
        read = []
        for force in (0.0, pretension_n()):
            with open_rig(changed, pretension_n=force) as rig:
                read.append(endpoint_m(rig.exchange(rig.sense_voltage_v)))
        return read[1] - read[0]


def endpoint_m(sample: RawSample) -> float:
    """Return the laser's reading [m]. Raises RigError on a rig without one."""
    if sample.endpoint_displacement_m is None:
        raise RigError("this rig has no laser at the finger's endpoint: open the finger's rig, which has one")
    return sample.endpoint_displacement_m
