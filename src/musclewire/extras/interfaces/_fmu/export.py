"""Write the FMU of a wire on its load, or of a controller."""

from __future__ import annotations

import io
import os
import platform
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple, TypeGuard

from musclewire.controllers import FuzzyPidSettings
from musclewire.errors import CallerError, NumericsError, argument
from musclewire.extras.board import limits_of_rig, settings_in_c
from musclewire.extras.interfaces._fmu.contents import FmuContents, FmuVariables, Role, fmu_texts
from musclewire.extras.interfaces._fmu.controller import LoopInFmu, controller_contents
from musclewire.extras.interfaces._fmu.wire import wire_contents
from musclewire.identify import check_made_for
from musclewire.rigs import RigConfiguration, rig_configuration
from musclewire.sensing import SensingModel
from musclewire.signals import RunFacts, write_whole

# The earliest time that a zip archive can hold: with the day of the export in it no two exports would be alike.
NO_TIME = (1980, 1, 1, 0, 0, 0)
SOURCES_ONLY = argument("sources_only", True)


def archive_bytes(contents: Mapping[str, bytes]) -> bytes:
    """Return the bytes of a zip archive with these files, by their path in it."""
    written = io.BytesIO()
    with zipfile.ZipFile(written, "w", zipfile.ZIP_DEFLATED) as archive:
        for path in sorted(contents):
            entry = zipfile.ZipInfo(path, NO_TIME)
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.external_attr = (0o755 if path.startswith("binaries/") else 0o644) << 16
            archive.writestr(entry, contents[path])
    return written.getvalue()


def write_archive(path: Path, content: bytes, *, overwrite: bool) -> None:
    """Write an FMU whole or not at all; its folder is made if need be, another file only replaced on request."""
    if not overwrite and path.exists() and path.read_bytes() != content:
        raise CallerError(
            f"{path} is another FMU: choose another folder or name, or allow replacing ("
            + argument("overwrite", True)
            + ")"
        )
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise CallerError(f"cannot make the folder {path.parent}: {error.strerror or error}") from error

    def write(temporary: Path) -> None:
        temporary.write_bytes(content)

    write_whole(path, write)


FLAGS = ("-std=c99", "-O2", "-ffp-contract=off", "-fPIC", "-shared", "-fvisibility=hidden", "-w")
COMPILERS = ("cc", "gcc", "clang")
SUFFIXES = {"linux": ".so", "darwin": ".dylib", "win": ".dll"}


class FmuBinary(NamedTuple):
    """A compiled binary: its path in the FMU, its bytes, and the compiler."""

    path: str
    content: bytes
    compiler: str


def binary_platform() -> str:
    """Return the folder of this machine's binaries as FMI 2.0 names it: ``linux64``, ``win64``, ``darwin64``."""
    system = next((name for name in SUFFIXES if sys.platform.startswith(name)), sys.platform)
    return f"{system}{'64' if sys.maxsize > 2**32 else '32'}"


def compiled_binary(name: str, sources: Mapping[str, str]) -> FmuBinary:
    """Return the binary of an FMU's sources, by the compiler of the environment variable CC, or cc, gcc or clang.

    Raises CallerError if there is no compiler or no platform of FMI 2.0 here, and NumericsError with the compiler's
    first complaint.
    """
    compiler = compiler_here()
    place = binary_platform()
    suffix = next((suffix for system, suffix in SUFFIXES.items() if place.startswith(system)), None)
    if suffix is None:
        raise CallerError(f"FMI 2.0 has no name for binaries of {sys.platform}: export with " + SOURCES_ONLY)
    with tempfile.TemporaryDirectory() as temporary:
        folder, out = Path(temporary), f"{name}{suffix}"
        for file, text in sources.items():
            (folder / file).write_text(text, encoding="utf-8")
        files = sorted(file for file in sources if file.endswith(".c"))
        compile_in(folder, [*compiler, *FLAGS, *files, "-o", out])
        return FmuBinary(f"binaries/{place}/{out}", (folder / out).read_bytes(), " ".join(compiler))


def compile_in(folder: Path, command: list[str]) -> None:
    """Run a compiler in a folder. Raises NumericsError with its first complaint."""
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    if done.returncode:
        lines = (done.stderr or done.stdout).strip().splitlines() or ["nothing was printed"]
        first = next((line for line in lines if "error" in line), lines[0])
        raise NumericsError(
            f"{command[0]} cannot compile the FMU for {platform.machine()}: {first}; export with "
            + SOURCES_ONLY
            + " and let the importing tool compile"
        )


def compiler_here() -> list[str]:
    """Return the command of a C compiler. Raises CallerError if there is none."""
    named = os.environ.get("CC")
    if named:
        command = shlex.split(named)
        if command and shutil.which(command[0]):
            return command
        raise CallerError(f"the environment variable CC names {named!r}, which is not there: correct or unset it")
    found = next((name for name in COMPILERS if shutil.which(name)), None)
    if found is None:
        raise CallerError(
            "there is no C compiler (cc, gcc, clang) for the FMU's binary: install one (apt-get install gcc "
            "libc6-dev), or export with " + SOURCES_ONLY + " for tools that compile it themselves"
        )
    return [found]


FMI_VERSION = "2.0"
NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,62}")


class Fmu(NamedTuple):
    """An FMU that was written."""

    path: Path  # the file
    kind: str  # "wire" or "controller"
    step_s: float  # communication step that importing tools take by default: the rig's sample period
    variables: FmuVariables  # inputs, outputs and parameters in the order of their value references
    files: tuple[str, ...]  # every file of the archive by its path in it
    platform: str  # folder of the binary, as ``linux64``; empty if the FMU has sources only
    compiler: str  # the compiler of the binary; empty if the FMU has sources only
    left_out: tuple[str, ...]  # what the rig or model has and the FMU has not, one line each

    def names(self, role: Role) -> list[str]:
        """Return the names of the variables of one role, in the order of their value references."""
        return [variable.name for variable in self.variables.ordered if variable.role == role]


def is_model(source: object) -> TypeGuard[str | Path | SensingModel]:
    """Return whether a source is a controller's: a model, or the path of a model file (.json)."""
    return isinstance(source, SensingModel) or (isinstance(source, (str, Path)) and Path(source).suffix == ".json")


def export_fmu(
    source: str | Path | RigConfiguration | SensingModel,
    folder: str | Path,
    *,
    name: str | None = None,
    rig: str | Path = "simulated",
    estimator: str = "filter",
    controller: str = "inverse-model",
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
    estimator
        For a controller: the one that gives it its estimate, "filter" or the paper's "polynomial".
    controller
        Which controller: "inverse-model", by the gains that the model keeps, or the paper's "fuzzy-pid".
    settings
        Those of the fuzzy PID, if it is that one; the paper's by default, with the error unit of the model's quantity.
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
        For a rig that is not simulated, or with two wires; a model of another wire than the rig's, or without what
        estimator or controller need; a name that is no C identifier; another FMU of that name; or if there is no C
        compiler and ``sources_only`` is not asked for.
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
    if is_model(source):
        contents = contents_of_model(source, chosen, rig, (estimator, controller, settings))
    else:
        assert not isinstance(source, SensingModel)
        contents = contents_of_wire(source)
    texts = fmu_texts(chosen, contents)
    sources = {path.removeprefix("sources/"): text for path, text in texts.items() if path.startswith("sources/")}
    binary = None if sources_only else compiled_binary(chosen, sources)
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


def contents_of_model(
    source: str | Path | SensingModel, name: str, rig: str | Path, asked: tuple[str, str, FuzzyPidSettings | None]
) -> FmuContents:
    """Return what is in the FMU of a model's controller, by the estimator and controller asked for."""
    from musclewire.sensing import load_model

    estimator, controller, fuzzy = asked
    model = source if isinstance(source, SensingModel) else load_model(str(source))
    limits, known = limits_of_rig(rig)
    check_made_for(model, known)
    period_s = RunFacts(known, "this rig").sample_period_s
    file = None if isinstance(source, SensingModel) else Path(source)
    settings = settings_in_c(model, controller, fuzzy, sample_period_s=period_s, file=file)
    return controller_contents(name, LoopInFmu(model, estimator, controller, settings, limits), period_s)


def contents_of_wire(source: str | Path | RigConfiguration) -> FmuContents:
    """Return what is in the FMU of a simulated rig's wire. Raises CallerError for a rig that is not simulated."""
    configuration, where = rig_configuration(source)
    if not isinstance(configuration, RigConfiguration):
        raise CallerError(
            f"{where} is not simulated: an FMU is a simulated wire, or the controller of a model file (.json)"
        )
    return wire_contents(configuration, where)
