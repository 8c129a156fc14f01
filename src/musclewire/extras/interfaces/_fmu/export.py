"""Write the FMU of a wire on its load, or of a controller."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

from musclewire.controllers import FuzzyPidSettings
from musclewire.errors import CallerError
from musclewire.extras.board import limits_of_rig
from musclewire.extras.interfaces._fmu.archive import archive_bytes, write_archive
from musclewire.extras.interfaces._fmu.binary import compiled_binary
from musclewire.extras.interfaces._fmu.contents import FmuContents, fmu_texts
from musclewire.extras.interfaces._fmu.controller import controller_contents
from musclewire.extras.interfaces._fmu.variables import FmuVariables, Role
from musclewire.extras.interfaces._fmu.wire import wire_contents
from musclewire.identify import check_made_for, settings_for
from musclewire.rigs import RigConfiguration, rig_configuration
from musclewire.sensing import SensingModel
from musclewire.signals import RunFacts

FMI_VERSION = "2.0"
NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,62}")


class Fmu(NamedTuple):
    """An FMU that was written.

    Parameters
    ----------
    path
        The file.
    kind
        "wire" or "controller".
    step_s
        Communication step [s] that importing tools take by default: the rig's sample period.
    variables
        Inputs, outputs and parameters in the order of their value references.
    files
        Every file of the archive by its path in it.
    platform
        Folder of the binary, as ``linux64``; empty if the FMU has sources only.
    compiler
        The compiler of the binary; empty if the FMU has sources only.
    left_out
        What the rig or model has and the FMU has not, one line each.
    """

    path: Path
    kind: str
    step_s: float
    variables: FmuVariables
    files: tuple[str, ...]
    platform: str
    compiler: str
    left_out: tuple[str, ...]

    def names(self, role: Role) -> list[str]:
        """Return the names of the variables of one role.

        Parameters
        ----------
        role
            "input", "output", "fixed" (parameters, set before a simulation), or "constant".

        Returns
        -------
        Their names, in the order of their value references.
        """
        return [variable.name for variable in self.variables.ordered if variable.role == role]


def is_model(source: object) -> bool:
    """Return whether a source is a controller's: a model, or the path of a model file (.json)."""
    return isinstance(source, SensingModel) or (isinstance(source, (str, Path)) and Path(source).suffix == ".json")


def export_fmu(
    source: str | Path | RigConfiguration | SensingModel,
    folder: str | Path,
    *,
    name: str | None = None,
    rig: str | Path = "simulated",
    settings: FuzzyPidSettings | None = None,
    sources_only: bool = False,
    overwrite: bool = False,
) -> Fmu:
    """Write an FMU for co-simulation (FMI 2.0): of a simulated wire on its load, or of a controller.

    It contains its C sources, and a binary for this machine by the C compiler that is there.

    Parameters
    ----------
    source
        A simulated rig (``"simulated"``, another name, a rig file, a configuration): the FMU of its wire. Or a model
        (a ``SensingModel``, or a model file, which ends in ``.json``): the FMU of its controller.
    folder
        Where the FMU is written; made if need be.
    name
        Name of the FMU and of its file without ``.fmu``: a C identifier. "wire" or "controller" if None.
    rig
        For a controller: the rig whose circuit and limits are taken; the paper's bench by default.
    settings
        For a controller: those of the fuzzy-tuned PID; the paper's by default, with the error unit of the model's
        quantity.
    sources_only
        Leave the binary out: for tools that compile an FMU's sources themselves, and machines without a compiler.
    overwrite
        Whether another FMU of this name may be replaced.

    Returns
    -------
    The FMU that was written.

    Raises
    ------
    CallerError
        For a rig that is not simulated, or with two wires; a model of another wire than the rig's; a name that is no C
        identifier; another FMU of that name; or if there is no C compiler and ``sources_only`` is not asked for.
    NumericsError
        If the compiler refuses the sources.

    Notes
    -----
    The same source, version and compiler give the same bytes.

    References
    ----------
    Functional Mock-up Interface 2.0, fmi-standard.org.

    Examples
    --------
    >>> import musclewire as mw
    >>> fmu = mw.export_fmu("simulated", "fmus", sources_only=True)
    >>> fmu.path.name, fmu.step_s
    ('wire.fmu', 0.05)
    """
    kind = "controller" if is_model(source) else "wire"
    chosen = kind if name is None else name
    if not NAME.fullmatch(chosen):
        raise CallerError(f"the FMU's name {chosen!r} must be a C identifier: letters, digits and _, at most 63")
    contents = contents_of(source, chosen, rig, settings)
    texts = fmu_texts(chosen, contents)
    binary = None if sources_only else compiled_binary(chosen, sources_of(texts))
    files = {path: text.encode("utf-8") for path, text in texts.items()}
    if binary is not None:
        files[binary.path] = binary.content
    path = Path(folder) / f"{chosen}.fmu"
    write_archive(path, archive_bytes(files), overwrite=overwrite)
    return Fmu(
        path=path,
        kind=kind,
        step_s=contents.step_s,
        variables=contents.variables,
        files=tuple(sorted(files)),
        platform=binary.path.split("/")[1] if binary is not None else "",
        compiler=binary.compiler if binary is not None else "",
        left_out=contents.left_out,
    )


def sources_of(texts: Mapping[str, str]) -> dict[str, str]:
    """Return the C files of an FMU by name."""
    return {path.removeprefix("sources/"): text for path, text in texts.items() if path.startswith("sources/")}


def contents_of(
    source: str | Path | RigConfiguration | SensingModel,
    name: str,
    rig: str | Path,
    settings: FuzzyPidSettings | None,
) -> FmuContents:
    """Return what is in the FMU of a source."""
    from musclewire.sensing import load_model

    if isinstance(source, SensingModel) or is_model(source):
        model = source if isinstance(source, SensingModel) else load_model(str(source))
        limits, known = limits_of_rig(rig)
        check_made_for(model, known)
        period_s = RunFacts(known, "this rig").sample_period_s
        return controller_contents(name, model, settings_for(model, settings), limits, period_s)
    configuration, where = rig_configuration(source)
    if not isinstance(configuration, RigConfiguration):
        raise CallerError(
            f"{where} is not simulated: an FMU is a simulated wire, or the controller of a model file (.json)"
        )
    return wire_contents(configuration, where)
