"""From the word ``simulated`` or a TOML file to an open rig."""

from __future__ import annotations

from importlib.resources import files
from pathlib import Path

from musclewire.errors import CallerError, an_object, nearest_hint
from musclewire.manifest import absent_part, folder_of, manifests, offered
from musclewire.parameters import is_wire_file, read_toml, require_seed, validated
from musclewire.rigs._beyond_catalogue import beyond_catalogue as beyond
from musclewire.rigs._beyond_catalogue import confirmed_beyond
from musclewire.rigs._guarded import GuardedRig
from musclewire.rigs._kinds import DEVICES, DeviceConfiguration
from musclewire.rigs._mounted_wire import MountedWire
from musclewire.rigs._outside import imported_kind, is_outside, known_kind
from musclewire.rigs._simulated_configuration import RigConfiguration

SIMULATED = "simulated"
# Rig files that ship with musclewire, each known by its name.
FOLDER = Path(str(files("musclewire.parameters"))) / "data" / "rigs"


def shipped_rig_files() -> dict[str, Path]:
    """Return the rig files of the core, then those of the parts that are there, by name."""
    folders = [FOLDER, *(folder_of(manifest.rig_files) for manifest in manifests() if manifest.rig_files)]
    return {file.stem: file for folder in reversed(folders) for file in sorted(folder.glob("*.toml"))}


def read_rig_file(path: str | Path, *, may_import: bool = False) -> DeviceConfiguration:
    """Return a rig file, checked. Raises CallerError naming the file, the key and the nearest right key.

    Only with ``may_import`` is the module of a kind "python:module:Class" imported: for the file that the user named.
    """
    file = Path(path)
    data = read_toml(file, "rig file", "; use the word 'simulated' for the simulated rig")
    if not data:
        raise CallerError(f"rig file {file} states nothing: 'kind = \"simulated\"' is the least of a rig file")
    kind = str(data.get("kind", SIMULATED))
    try:
        if is_outside(kind) and not may_import:
            raise CallerError(f"kind '{kind}' runs code of a module: only a rig that is opened by its path may do that")
        known = imported_kind(kind, file.parent) if is_outside(kind) else DEVICES.find(kind)
    except CallerError as error:
        raise CallerError(f"rig file {file}: {error}") from None
    wire = data.get("wire")
    if issubclass(known.configuration, MountedWire) and isinstance(wire, str) and is_wire_file(wire):
        data["wire"] = str((file.parent / wire).absolute())  # voltages that the file leaves out are the wire file's
    configuration: DeviceConfiguration = validated(known.configuration, data, f"rig file {file}")
    return configuration.with_files_in(file.parent)


def rig_names() -> list[str]:
    """Return the names of the rig files that ship with musclewire, after the word for the paper's bench."""
    return [SIMULATED, *sorted(shipped_rig_files())]


def simulated_configuration(rig: str | Path | RigConfiguration) -> tuple[RigConfiguration, str]:
    """Return the configuration of a simulated rig, for experiments that change the load of its wire.

    Raises CallerError for a rig that is not simulated.
    """
    configuration, where = rig_configuration(rig)
    if not isinstance(configuration, RigConfiguration):
        raise CallerError(f"{where} is not simulated: this experiment changes what the wire pulls, on a simulated rig")
    return configuration, where


def rig_configuration(
    rig: str | Path | DeviceConfiguration, *, may_import: bool = False
) -> tuple[DeviceConfiguration, str]:
    """Return a rig's configuration and its name in messages, from a name, the path of a rig file, or a configuration.

    ``may_import`` is that of ``read_rig_file``. Raises CallerError for an unknown name, a missing file and an invalid
    file.
    """
    if not isinstance(rig, DeviceConfiguration | str | Path):
        raise CallerError(
            f"a rig is given by its name, the path of a rig file or a configuration, not by {an_object(rig)}: a device "
            'of your own is named in a rig file, kind = "python:module:Class"'
        )
    if isinstance(rig, DeviceConfiguration):
        return rig.model_copy(update={"beyond_catalogue": True}) if confirmed_beyond() else rig, "rig"
    if str(rig) == SIMULATED:
        return RigConfiguration(), SIMULATED
    named, shipped = offered("rig_names").get(str(rig), str(rig)), shipped_rig_files()
    if named in shipped and (named == str(rig) or not Path(rig).exists()):
        return read_rig_file(shipped[named]), f"rig {named}"
    if Path(rig).suffix != ".toml" and not Path(rig).exists():
        if (absent := absent_part("rig_files", str(rig))) is not None:
            raise absent
        hint = nearest_hint(str(rig), rig_names())
        or_file = " Otherwise give" if hint.endswith("?") else ", or give"
        raise CallerError(f"there is no rig '{rig}'{hint}{or_file} the path of a TOML rig file")
    return read_rig_file(rig, may_import=may_import), f"rig file {rig}"


def require_rig(rig: str) -> None:
    """Raise CallerError for an unknown name, a missing file and an invalid one; no module is imported for it."""
    if Path(rig).is_file() and is_outside(str(read_toml(Path(rig), "rig file").get("kind", SIMULATED))):
        return  # its keys are those of the class, which only the rig's own process imports
    rig_configuration(rig)


def open_rig(
    rig: str | Path | DeviceConfiguration = "simulated",
    *,
    wire: str | None = None,
    bench: str | None = None,
    seed: int | None = None,
    real_time: bool = False,
    clock_speed: float = 1.0,
    beyond_catalogue: bool = False,
    **settings: float | str,
) -> GuardedRig:
    """Open a rig: the wire with its driver and instruments, simulated or real, with the protection around it.

    Use it in a ``with`` block, at whose end the drive is switched off whatever happens inside.

    Parameters
    ----------
    rig
        ``"simulated"`` for the paper's bench, the name of another rig that ships with musclewire (``"finger"``,
        ``"gripper"``), the path of a TOML rig file, or a configuration. A rig file of another kind (``kind = "nidaq"``,
        "serial", "replay", or one that a package has added) opens hardware or a recording. A rig file of kind
        "python:module:Class" runs a class of your own module, which is imported here: open none that you do not trust.
    wire
        Name or wire file (as ``musclewire calibrate`` writes it) of another wire than the simulated rig's own.
    bench
        Name of another bench than the simulated rig's own.
    seed
        Seed of the noise of a simulated rig, or of another kind whose files have the key ``seed``; by default that of
        its file, 1 if it names none.
    real_time
        Whether the computer's clock paces a simulated rig, which otherwise runs as fast as it can. Hardware has a clock
        of its own, and a replay none.
    clock_speed
        How many times as fast as the computer's clock a simulated rig runs with ``real_time``, 0.01 to 1000;
        :func:`musclewire.rigs._abilities.adjustable_clock_of` gives what changes it later.
    beyond_catalogue
        Whether numbers that no wire of the catalogue has or survives, as a length of 60 m or a limit of 5000 K, are
        meant so, as by the rig file's key of that name.
    **settings
        Numbers of wire and bench by name, in SI or as text with a unit: ``open_rig("simulated", pretension_n=1.7)``.

    Returns
    -------
    The rig, with 0 V at its output.

    Raises
    ------
    CallerError
        For unknown names, impossible numbers and those that no wire of the catalogue has or survives, for settings that
        the rig's own load leaves without effect, a clock speed without a clock, and for wire, bench, seed, clock
        speed and settings of a rig that is not simulated: its numbers are in its file.
    RigError
        If hardware cannot be opened.

    Examples
    --------
    >>> import musclewire as mw
    >>> with mw.open_rig("simulated", pretension_n="1.7 N") as rig:
    ...     rig.metadata()["pretension_n"]
    1.7
    """
    with beyond(beyond_catalogue):
        configuration, where = rig_configuration(rig, may_import=True)
    refuse_useless_speed(clock_speed, real_time, isinstance(configuration, RigConfiguration), where)
    if isinstance(configuration, RigConfiguration):
        from musclewire.rigs._simulated_configuration import open_simulated

        simulated = open_simulated(configuration, where, wire, bench, seed, real_time, settings)
        if simulated.adjustable_clock is not None:
            simulated.adjustable_clock.set_speed(clock_speed)
        return GuardedRig(simulated)
    if seed is not None and "seed" in type(configuration).model_fields:
        drawn_from = require_seed(seed, f"{where}: seed")
        configuration, seed = configuration.model_copy(update={"seed": drawn_from}), None
    changed = {"wire": wire, "bench": bench, "seed": seed, **settings}
    for name, value in changed.items():
        if value is not None:
            raise CallerError(f"{where}: '{name}' changes a simulated rig; on a real one, change the rig file")
    known = known_kind(configuration.kind) if is_outside(configuration.kind) else DEVICES.find(configuration.kind)
    opened = GuardedRig(known.open(configuration))
    if real_time and not opened.paced:
        opened.close()
        raise CallerError(f"{where} has no clock: leave out real_time")
    return opened


def refuse_useless_speed(clock_speed: float, real_time: bool, simulated: bool, where: str) -> None:
    """Raise CallerError for a clock speed that would have no effect on a rig."""
    if clock_speed == 1.0:
        return
    if not simulated:
        raise CallerError(f"{where} is not simulated, its clock runs as it does: leave out clock_speed")
    if not real_time:
        raise CallerError(
            f"{where} has no clock whose speed could be set, it runs as fast as it can: add real_time=True, "
            "or leave out clock_speed"
        )
