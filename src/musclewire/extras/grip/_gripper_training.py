"""Training a gripper: closings of its fingers with and without an object, and what is learned from them."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Literal

from pydantic import BaseModel, ConfigDict, ValidationError

from musclewire.errors import CallerError
from musclewire.experiment import OnSample, Waveform, WaveformPolicy, run_on_rig
from musclewire.extras.grip._contact_detection import FreeClosing
from musclewire.extras.grip._contact_fitting import KnownGrip, fit_free_closing, fit_grip_curve
from musclewire.extras.grip._grip_force import GripCurve
from musclewire.rigs import Rig, RigConfiguration, open_rig, simulated_configuration
from musclewire.signals import MetadataValue, Recording, RunFacts, write_text_whole
from musclewire.small_files import json_of, read_small
from musclewire.wire import ElasticObject

# How long a closing lasts. Fast enough that a draught of some seconds hardly changes meanwhile, slow enough that a
# sample of 50 ms is a small part of it (docs/explanation/force_self_sensing.md compares).
CLOSING_S = 2.5
# The wire cools before a closing, so that all closings begin in the same state.
REST_S = 10.0
# Power rises linearly to that of the slow sine's amplitude times (1 + LAG_S / duration): in a fast closing heat still
# flows into the wire when convection alone would have been served.
LAG_S = 1.75
# The gripper learns from closings at speeds that separate holding power from the energy of motion, each repeated to
# average over draughts, and from grips of one block of known stiffness at different openings, over which the lever
# changes.
TRAINING_CLOSINGS_S = (2.5, 4.0, 7.0) * 6
KNOWN_STIFFNESS_N_PER_M = 300.0
KNOWN_CLEARANCES_M = (4e-3, 5.5e-3, 7e-3, 8.5e-3) * 3
# Each known grip has draughts of its own: a draught common to all would be learned as the power of a newton.
SEED_STEP = 100
# An object that is taken away is this far away.
AWAY_M = 1.0
# A gripper is the trained one if its measured numbers agree within this fraction.
ALIKE = 0.01
SHOWN = {
    "wire": ("wire", 1.0, ""),
    "leg_length_m": ("legs of", 1e3, " mm"),
    "finger": ("finger", 1.0, ""),
    "finger_stiffness_n_per_m": ("finger stiffness", 1.0, " N/m"),
    "fingers": ("fingers:", 1.0, ""),
    "pretension_n": ("pretension", 1.0, " N"),
}


@dataclass(frozen=True)
class Gripper:
    """Identity of the gripper that was trained; None for what a rig does not state.

    Parameters
    ----------
    wire
        Name of the wire.
    leg_length_m
        Length of a leg of the wire [m].
    finger
        Name of the finger.
    finger_stiffness_n_per_m
        Stiffness of a finger along its tendon [N/m].
    fingers
        Number of fingers.
    pretension_n
        Pretension of the wire [N].
    """

    wire: str | None
    leg_length_m: float | None
    finger: str | None
    finger_stiffness_n_per_m: float | None
    fingers: int
    pretension_n: float | None

    def require_same(self, other: Gripper) -> None:
        """Raise CallerError if the other gripper is known to differ; measured numbers may differ by 1 %."""
        for item in fields(self):
            learned, mounted = getattr(self, item.name), getattr(other, item.name)
            if learned is None or mounted is None or same(learned, mounted):
                continue
            raise CallerError(
                f"learned on another gripper: {in_words(item.name, learned)} there, "
                f"{in_words(item.name, mounted)} here: train this one, into another file"
            )


def same(one: str | float, other: str | float) -> bool:
    """Return whether two values belong to the same gripper."""
    if isinstance(one, str) or isinstance(other, str):
        return one == other
    return math.isclose(one, other, rel_tol=ALIKE)


def in_words(name: str, value: str | float) -> str:
    """Return one property of a gripper as text with its unit."""
    label, factor, unit = SHOWN[name]
    return f"{label} {value}" if isinstance(value, str) else f"{label} {factor * value:.4g}{unit}"


@dataclass(frozen=True)
class GripperKnowledge:
    """What a gripper has learned.

    Parameters
    ----------
    free
        Power and resistance of closing without an object: the reference for contact.
    curve
        Force as a function of resistance.
    gripper
        Identity of the gripper.
    """

    free: FreeClosing
    curve: GripCurve
    gripper: Gripper

    def save(self, path: Path) -> None:
        """Write it as JSON, whole or not at all.

        Parameters
        ----------
        path
            The file; one of that name is replaced.

        Raises
        ------
        CallerError
            If the folder cannot be written to.
        """
        file = GripperFile(
            format="musclewire-gripper", version=2, free=self.free, curve=self.curve, gripper=self.gripper
        )
        write_text_whole(path, file.model_dump_json(indent=1) + "\n")


class GripperFile(BaseModel):
    """The keys of a file with what a gripper has learned; anything else is an error."""

    model_config = ConfigDict(extra="forbid")

    format: Literal["musclewire-gripper"]
    version: Literal[2]
    free: FreeClosing
    curve: GripCurve
    gripper: Gripper


def load_knowledge(path: Path) -> GripperKnowledge:
    """Read what a gripper has learned; CallerError for a file that is missing, damaged or of another program."""
    try:
        file = GripperFile.model_validate(json_of(read_small(path, "gripper file"), str(path)))
    except ValidationError as error:
        fault = error.errors(include_url=False, include_input=False)[0]
        raise CallerError(
            f"{path} is not what a gripper has learned: {'.'.join(map(str, fault['loc']))}: {fault['msg']}; train the "
            "gripper again, 'musclewire grip --learned' writes such a file"
        ) from None
    return GripperKnowledge(file.free, file.curve, file.gripper)


def closing_waveform(rig: Rig, closing_s: float, rest_s: float = REST_S) -> Waveform:
    """Return drive over time: a rest at the sense voltage, then power that rises linearly as far as the rig allows.

    Raises CallerError for a closing so fast that the rig does not allow its voltage.
    """
    if not (closing_s > 0.0 and rest_s >= 0.0):
        raise CallerError(f"a closing of {closing_s:g} s after a rest of {rest_s:g} s: give a duration above 0")
    low = rig.sense_voltage_v
    high = rig.drive_amplitude_v * math.sqrt(1.0 + LAG_S / closing_s)
    if high > rig.maximum_voltage_v:
        raise CallerError(
            f"closing in {closing_s:g} s ends at {high:.3g} V and the rig allows {rig.maximum_voltage_v:g} V: set "
            f"maximum_voltage_v = {math.ceil(10.0 * high) / 10.0:g} under [settings] of the rig file, or a lower "
            "drive_amplitude_v there"
        )

    def drive_voltage_v(time_s: float) -> float:
        fraction = min(max((time_s - rest_s) / closing_s, 0.0), 1.0)
        return math.sqrt(low**2 + (high**2 - low**2) * fraction)

    return drive_voltage_v


def close_fingers(
    rig: Rig, *, closing_s: float = CLOSING_S, rest_s: float = REST_S, on_sample: OnSample | None = None
) -> Recording:
    """Let the wires cool, close the fingers once, and return the recording.

    Parameters
    ----------
    rig
        The gripper, open; it is driven.
    closing_s
        Time in which power rises [s]; 2.5 s are short compared with a draught and long compared with a sample.
    rest_s
        Time to cool before [s], so that all closings begin in the same state.
    on_sample
        Gets every recorded row; it may raise to stop the run.

    Returns
    -------
    The recording.

    Raises
    ------
    CallerError
        For a duration not above 0, or a closing so fast that the rig does not allow its voltage.
    """
    waveform = closing_waveform(rig, closing_s, rest_s)
    policy = WaveformPolicy(waveform, rest_s + closing_s)
    metadata: dict[str, MetadataValue] = {"experiment": "closing", "closing_s": closing_s, "rest_s": rest_s}
    return run_on_rig(rig, policy, rest_s + closing_s, metadata=metadata, on_sample=on_sample)


def with_object(rig: str | Path | RigConfiguration, block: ElasticObject | None) -> RigConfiguration:
    """Return a rig with another block between its fingers, or with it taken away.

    Parameters
    ----------
    rig
        A simulated gripper: a name, a file or its configuration.
    block
        The block; None takes it away.

    Returns
    -------
    The changed configuration.

    Raises
    ------
    CallerError
        For a rig without finger or part "contact".
    """
    configuration, _ = simulated_configuration(rig)
    there = object_of(rig)
    wanted = block or ElasticObject(there.stiffness_n_per_m, AWAY_M)
    load = [part.with_obstacle(wanted) for part in configuration.load]
    return configuration.model_copy(update={"load": load})


def object_of(rig: str | Path | RigConfiguration) -> ElasticObject:
    """Return the block between a rig's fingers. Raises CallerError for a rig without finger or part "contact"."""
    configuration, where = simulated_configuration(rig)
    block = next((part.obstacle for part in configuration.load if part.obstacle is not None), None)
    if block is None or not any(part.finger_name is not None for part in configuration.load):
        raise CallerError(
            f"{where} has nothing to grip: it needs the parts 'finger' and 'contact', as the rig 'gripper' has"
        )
    return block


def gripper_of(rig: Rig) -> Gripper:
    """Return the identity of a gripper from its rig's metadata.

    Parameters
    ----------
    rig
        The rig.

    Returns
    -------
    The gripper; what the rig does not state is None.
    """
    facts = RunFacts(rig.metadata(), "this rig")
    return Gripper(
        wire=facts.text_or_none("wire"),
        leg_length_m=facts.number_or_none("leg_length_m"),
        finger=facts.text_or_none("finger"),
        finger_stiffness_n_per_m=facts.number_or_none("finger_stiffness_n_per_m"),
        fingers=int(facts.wires),
        pretension_n=facts.number_or_none("pretension_n"),
    )


def train_gripper(
    rig: str | Path | RigConfiguration, *, seed: int | None = None, on_sample: OnSample | None = None
) -> GripperKnowledge:
    """Learn a simulated gripper: free closings at several speeds, and grips of a block of 300 N/m.

    For this, and only for this, the instruments are read: connector and endpoint, and the load cell on the known block.
    For real fingers pass the same recordings to ``fit_free_closing`` and ``fit_grip_curve``.
    """
    configuration, _ = simulated_configuration(rig)
    fingers = 2 if any(part.second_wire and part.second_wire.holds_the_object for part in configuration.load) else 1
    with open_rig(with_object(configuration, None), seed=seed) as opened:
        free_runs = [close_fingers(opened, closing_s=time_s, on_sample=on_sample) for time_s in TRAINING_CLOSINGS_S]
        gripper = gripper_of(opened)
    free = fit_free_closing(free_runs)
    known = []
    first_seed = configuration.seed if seed is None else seed
    for index, clearance_m in enumerate(KNOWN_CLEARANCES_M, start=1):
        block = ElasticObject(KNOWN_STIFFNESS_N_PER_M, clearance_m * fingers / 2.0)
        with open_rig(with_object(configuration, block), seed=first_seed + SEED_STEP * index) as opened:
            known.append(KnownGrip(close_fingers(opened, on_sample=on_sample), KNOWN_STIFFNESS_N_PER_M))
    return GripperKnowledge(free, fit_grip_curve(free_runs, known, free, fingers=fingers), gripper)
