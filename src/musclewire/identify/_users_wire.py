"""The wire of a user's file on the load and in the circuit of a rig, for estimators on physics."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from musclewire.errors import CallerError
from musclewire.parameters import bench_known_with, is_wire_file, load_alloy, load_bench, load_wire
from musclewire.signals import MetadataValue, RunFacts
from musclewire.wire import WireConstants, constants_of, measured_grains

# Numbers of the bench that a rig or a recording may state; they count before those of the wire file.
STATED = ("wire_length_m", "pretension_n", "spring_stiffness_n_per_m", "shunt_resistance_ohm", "guide_friction_n")
# Without these the load is not known.
LOAD = ("spring_stiffness_n_per_m", "pretension_n", "wire_length_m")


def users_wire(path: str | Path, known: Mapping[str, MetadataValue]) -> WireConstants:
    """Return the constants of a wire file's wire on the load that a rig or a recording states.

    Parameters
    ----------
    path
        The wire file (.toml), as ``calibrate`` writes it.
    known
        Metadata of a rig or a recording: length, pretension and stiffness count before those in the file.

    Returns
    -------
    The constants, cooled under the pretension.

    Raises
    ------
    CallerError
        If it is no wire file, or neither it nor the metadata state length, pretension and stiffness of a spring.
    """
    name = str(path)
    if not is_wire_file(name):
        raise CallerError(f"{name} is no wire file: musclewire calibrate -o wire.toml writes one from a recording")
    facts = RunFacts(known, "this rig")
    in_file = {key: item.value for key, item in bench_known_with(name).items()}
    stated = {key: number for key in STATED if (number := facts.number_or_none(key)) is not None}
    lacking = [key for key in LOAD if key not in in_file and key not in stated]
    if lacking or ("load" in known and "spring_stiffness_n_per_m" not in known):
        what = ", ".join(lacking) or f"the stiffness of one spring (the load is {known['load']})"
        raise CallerError(
            f"wire file {name}: neither it nor the rig states {what}: calibrate on this load, or go without the file"
        )
    wire, alloy = load_wire(name), load_alloy(name)
    bench = load_bench("paper").values() | in_file | stated
    leg_m = facts.leg_length_or_none_m
    if leg_m:
        bench["legs"] = round(bench["wire_length_m"] / leg_m)
    return constants_of(alloy.values(), wire.values(), bench, distribution=measured_grains(alloy))
