"""The kinds of recordings of a calibration: a driven wire, isobars, or a cooling curve; and the starting wire."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import NamedTuple

from musclewire.errors import CallerError, MusclewireError, RecordingError, argument
from musclewire.extras.calibration._physical.bench import assumed_of_bench, diameter_of
from musclewire.extras.calibration._physical.cooling import CoolingObservation, observe_cooling
from musclewire.extras.calibration._physical.driven import DrivenObservation, observe_drive
from musclewire.extras.calibration._physical.isobaric import (
    IsobaricObservation,
    counts_contraction,
    in_elongation,
    isobars_in,
    observe_isobars,
)
from musclewire.extras.calibration._physical.observations import Observation
from musclewire.identify import IsobaricLoop
from musclewire.judge import judge_readings
from musclewire.parameters import Alloy, Bench, Parameter, PriorSet, Wire, load_alloy, load_bench, load_wire
from musclewire.signals import ISOBAR_TABLE, Recording

ELECTRICAL = ("drive_voltage_v", "wire_voltage_v", "shunt_voltage_v", "wire_current_a", "wire_resistance_ohm")
# Parameters on which a kind of observation does not depend, by parts of their names.
ELECTRICITY, HEAT, GUIDE = ("resistivity",), ("specific_heat", "latent_heat", "convection"), ("guide_friction",)
# The highest voltage allowed exceeds the highest one recorded by this factor.
VOLTAGE_HEADROOM = 1.125


class StartingPoint(NamedTuple):
    """Alloy, wire and bench that a search starts from; numbers that it does not fit keep their value."""

    alloy: Alloy
    wire: Wire
    bench: Bench


def start_of(
    recordings: Mapping[str, Recording], wire: str, given: Mapping[str, float]
) -> tuple[StartingPoint, list[str]]:
    """Return a search's start, with assumptions. Raises CallerError for an unknown wire, or recordings of several."""
    named = load_wire(wire)
    diameter = diameter_of(recordings, given)
    notes: list[str] = []
    if diameter is None and not all(is_isobaric(item) for item in recordings.values()):
        notes.append(
            f"assumed: {1e6 * named.diameter_m.value:.4g} um wire, as {wire} ("
            + argument("bench", {"diameter_m": "100 um"})
            + ")"
        )
    if diameter is not None:
        named = wire_of_diameter(named, diameter)
    driven = [item["drive_voltage_v"].max() for item in recordings.values() if "drive_voltage_v" in item]
    if driven and max(driven) > 0.0:
        named = wire_with_drive(named, float(max(driven)))
    return StartingPoint(load_alloy(named.alloy), named, load_bench("paper")), notes


def wire_of_diameter(wire: Wire, diameter_m: float) -> Wire:
    """Return a wire drawn to another diameter; forces and resistance follow from its cross section."""
    ratio = (diameter_m / wire.diameter_m.value) ** 2
    if ratio == 1.0:
        return wire
    source = "the recordings or the user"
    changes = {"diameter_m": Parameter(value=diameter_m, unit="m", kind="measured", source=source)}
    powers = {"resistance_per_metre_ohm_per_m": -1, "maximum_force_n": 1, "nominal_force_n": 1}
    for name, power in powers.items():
        item = getattr(wire, name)
        source = f"that of {wire.name}, with the section of this wire"
        changes[name] = item.model_copy(
            update={"value": item.value * ratio**power, "kind": "derived", "source": source, "note": ""}
        )
    return wire.model_copy(update=changes)


def wire_with_drive(wire: Wire, highest_v: float) -> Wire:
    """Return a wire with the drive voltages of its recordings."""
    source = "the highest drive in the recordings"
    amplitude = Parameter(value=highest_v, unit="V", kind="measured", source=source)
    limit = Parameter(value=VOLTAGE_HEADROOM * highest_v, unit="V", kind="assumed", source=f"an eighth above {source}")
    return wire.model_copy(update={"drive_amplitude_v": amplitude, "maximum_voltage_v": limit})


def observations_of(
    recordings: Mapping[str, Recording], bench: Mapping[str, float] | None = None
) -> tuple[list[Observation], list[str]]:
    """Return recordings, by name, as observations, and notes on how they were understood.

    All isobars among them become one observation, with one zero of strain. Raises RecordingError for a recording that
    cannot constrain anything, CallerError if its bench is not known; both name the recording.
    """
    found: list[Observation] = []
    isobars: list[IsobaricLoop] = []
    isobar_names: list[str] = []
    notes: list[str] = []
    given = bench or {}
    for name, recording in recordings.items():
        with named_errors(name):
            if is_isobaric(recording):
                loops = isobars_in(recording)
                isobars += loops
                notes.append(f"{name}: {isobar_text(loops)}")
                isobar_names.append(name)
                continue
            refuse_tables(recording)
            electrical = any(column in recording for column in ELECTRICAL)
            observation = (observe_drive if electrical else observe_cooling)(recording, given, name)
            found.append(observation)
            kind = "driven from cold" if electrical else "cooling without current"
            channels = ", ".join(channel.name for channel in observation.channels)
            notes.append(f"{name}: {kind}; {channels}")
            notes += [f"{name}: {text}" for text in judge_readings(recording.columns, recording.metadata).findings]
            notes += ["assumed: " + text for text in assumed_of_bench(observation.bench)]
    if isobars:
        notes.append(f"strain of isobars: positive in {'contraction' if counts_contraction(isobars) else 'elongation'}")
        with named_errors(", ".join(isobar_names)):
            found.append(observe_isobars(in_elongation(isobars)))
    return found, list(dict.fromkeys(notes))


def is_isobaric(recording: Recording) -> bool:
    """Return whether a recording has temperature, strain and stress, and no drive."""
    return set(ISOBAR_TABLE) <= set(recording.names) and not any(column in recording for column in ELECTRICAL)


def isobar_text(isobars: list[IsobaricLoop]) -> str:
    """Return stresses and temperatures of isobars in words."""
    stresses = ", ".join(f"{item.stress_pa / 1e6:.4g}" for item in isobars)
    low, high = (pick(pick(item.temperature_k) for item in isobars) - 273.15 for pick in (min, max))
    return f"isobar{'s' if len(isobars) > 1 else ''} at {stresses} MPa, {low:.0f} to {high:.0f} C"


def refuse_tables(recording: Recording) -> None:
    """Raise RecordingError for a table of branches, pulses or numbered rows, which have no clock."""
    if recording.is_pulse_table or recording.metadata.get("clock") == "row numbers":
        raise RecordingError("has no clock, and heat cannot be followed without one: calibrate from samples over time")
    if recording.is_branch_table:
        raise RecordingError(
            "strain against resistance without drive and clock holds no information on heat, stress and temperature: "
            "calibrate from the recording it was taken from"
        )


@contextmanager
def named_errors(name: str) -> Iterator[None]:
    """Put the name of the recording at the head of error messages."""
    try:
        yield
    except (RecordingError, CallerError) as error:
        problem: MusclewireError = type(error)(f"{name}: " + str(error))
        raise problem from None


def observable_parameters(priors: PriorSet, observations: list[Observation]) -> list[str]:
    """Return the parameters on which these observations depend at all.

    Isobars depend on neither heat nor electricity, a cooling curve does not depend on electricity, and without sliding
    nothing depends on friction.
    """
    excluded: tuple[str, ...] = ()
    if not any(isinstance(item, DrivenObservation) for item in observations):
        excluded += ELECTRICITY
    if all(isinstance(item, IsobaricObservation) for item in observations):
        excluded += HEAT + GUIDE
    elif all(isinstance(item, IsobaricObservation | CoolingObservation) for item in observations) and not any(
        channel.name in ("strain", "force") for item in observations for channel in item.channels
    ):
        excluded += GUIDE
    return [name for name in priors.parameters if not any(word in name for word in excluded)]
