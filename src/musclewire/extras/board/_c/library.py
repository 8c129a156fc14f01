"""Write a model, its controller, its limits and the protection table as a self-contained C99 library."""

from __future__ import annotations

import re
from collections.abc import Mapping
from importlib.resources import files
from pathlib import Path
from typing import NamedTuple, TypedDict, Unpack

from musclewire.controllers import DriveLimits, FuzzyPidSettings, ProtectionLimits, RuleBase, load_rule_base
from musclewire.errors import CallerError, argument
from musclewire.extras.board._c.constants import CConstants, collect, control_numbers
from musclewire.extras.board._c.exercise import golden_vectors
from musclewire.extras.board._c.header import constants_header, model_checksum
from musclewire.extras.board._c.loops import ControllerSettings
from musclewire.extras.board._c.precision import check_precision, single_error_share
from musclewire.extras.board._c.reference import ReferenceTick
from musclewire.sensing import PAPER_ESTIMATOR, SensingModel

FUNCTION = re.compile(r"^\w+ \*?(mw_\w+)\(", re.M)
TYPE = re.compile(r"^\} (mw_\w+);", re.M)


def keywords_file(header: str) -> str:
    """Return keywords.txt, which colours types and functions of a header in the IDE's editor."""
    types, functions = sorted(set(TYPE.findall(header))), sorted(set(FUNCTION.findall(header)))
    lines = [f"{name}\tKEYWORD1" for name in types] + [f"{name}\tKEYWORD2" for name in functions]
    return "\n".join(lines) + "\n"


TEST_FILES = (
    "golden_test.c",
    "same_bits.c",
    "bench.h",
    "cortex_m/start.c",
    "cortex_m/mps2.ld",
    "cortex_m/tick_cost.c",
    "avr/tick_cost.c",
)
NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,30}")


class CLibrary(NamedTuple):
    """A library that was written: its folder, its name, its files (relative, in order) and its numbers."""

    folder: Path
    name: str
    files: tuple[str, ...]
    constants: CConstants
    single_error_share: float  # largest error of the estimate in single precision over the full scale
    golden_rows: int
    reference: ReferenceTick  # tick in Python that the golden vectors come from


def project_files(name: str, quantity: str) -> dict[str, str]:
    """Return the files around the sources, by their path in the library's folder, with the library's name filled in."""
    from importlib.metadata import version

    root = files("musclewire.extras.board") / "c_project"
    places = {
        "LICENSE": "LICENSE",
        "README.md": "README.md",
        "CMakeLists.txt": "CMakeLists.txt",
        "library.properties": "library.properties",
        "sketch.ino": f"examples/{name}/{name}.ino",
        **{f"test/{file}": f"test/{file}" for file in TEST_FILES},
    }
    filled = {"@NAME@": name, "@VERSION@": version("musclewire"), "@QUANTITY@": quantity}
    texts = {}
    for source, place in places.items():
        text = root.joinpath(*source.split("/")).read_text(encoding="utf-8")
        for key, value in filled.items():
            text = text.replace(key, value)
        texts[place] = text
    return texts


def loop_checksum(
    model: SensingModel,
    settings: ControllerSettings,
    rule_base: RuleBase | None = None,
    estimator: str = PAPER_ESTIMATOR,
) -> int:
    """Return the checksum of a library with this model and controller, which a board built with it reports."""
    return model_checksum(control_numbers(model, settings, rule_base, estimator))


def library_license() -> str:
    """Return the licence under which exported C is given away."""
    return (files("musclewire.extras.board") / "c_project" / "LICENSE").read_text(encoding="utf-8")


def library_sources() -> dict[str, str]:
    """Return the C files that are the same for every library, by name."""
    folder = files("musclewire.extras.board") / "c_library"
    return {
        item.name: item.read_text(encoding="utf-8") for item in folder.iterdir() if item.name.endswith((".c", ".h"))
    }


class LibraryForm(TypedDict, total=False):
    """Keywords of :func:`write_library`: precision, estimator, and whether files of another library are replaced."""

    double: bool
    estimator: str
    overwrite: bool


def write_library(
    model: SensingModel,
    settings: ControllerSettings,
    limits: DriveLimits,
    protection: ProtectionLimits,
    folder: str | Path,
    name: str = "musclewire",
    **form: Unpack[LibraryForm],
) -> CLibrary:
    """Write the library into a folder, which is made if need be; files of the same names are replaced.

    Without ``overwrite`` a file there with another content is left alone, and nothing is written at all; everything is
    checked before. ``settings`` say which controller it is: the fuzzy PID by its own, the inverse of the wire's model
    by the gains of the wire. ``double`` makes double precision the choice; without it all is checked to survive single
    precision. Raises CallerError for a number that overflows, underflows or loses its digits in single precision
    (named), drive limits other than the protection's, a name that is no C identifier, and a folder that cannot be
    written, or holds other files of these names without ``overwrite``.
    """
    double, overwrite = form.get("double", False), form.get("overwrite", True)
    estimator = form.get("estimator", PAPER_ESTIMATOR)
    if not NAME.fullmatch(name):
        raise CallerError(f"the library's name {name!r} must be a C identifier of at most 31 letters, digits and _")
    rules = load_rule_base(settings.rule_base) if isinstance(settings, FuzzyPidSettings) else None
    constants = collect(model, settings, rules, limits, protection, estimator)
    if not double:
        check_precision(model, constants)
    header = constants_header(
        constants,
        name=name,
        model=f"{model!r}, {model.source or 'source unknown'}",
        settings=settings,
        quantity=model.quantity,
        double=double,
    )
    reference = ReferenceTick(model, settings, limits, protection, rules, estimator)
    texts = {f"src/{file}": text for file, text in sorted(library_sources().items())}
    texts["src/mw_constants.h"] = header
    texts |= project_files(name, model.quantity)
    texts["keywords.txt"] = keywords_file(texts["src/musclewire.h"])
    texts["test/golden_vectors.csv"] = vectors = golden_vectors(reference)
    if not overwrite:
        refuse_replacing(Path(folder), texts)
    _write(Path(folder), texts)
    error = single_error_share(model, constants)
    return CLibrary(Path(folder), name, tuple(texts), constants, error, vectors.count("\n") - 1, reference)


def refuse_replacing(folder: Path, texts: Mapping[str, str]) -> None:
    """Raise CallerError if a file exists with other content: another wire's numbers, or the user's own work."""
    others = [name for name, text in texts.items() if differs(folder / name, text)]
    if others:
        more = f" and {len(others) - 1} more" if len(others) > 1 else ""
        raise CallerError(
            f"{folder} holds another {others[0]}{more}: choose another folder, or allow replacing ("
            + argument("overwrite", True)
            + ")"
        )


def differs(path: Path, text: str) -> bool:
    """Return whether a file exists at this path with content other than this text."""
    try:
        return path.read_bytes().decode("utf-8").replace("\r\n", "\n") != text
    except FileNotFoundError:
        return False
    except (OSError, UnicodeDecodeError):
        return path.is_file()  # in all other cases writing the file reports what is wrong


def _write(folder: Path, texts: dict[str, str]) -> None:
    """Write each file whole or not at all. Raises CallerError if one cannot be written."""
    from musclewire.signals import write_text_whole

    try:
        for name, text in texts.items():
            path = folder / name
            path.parent.mkdir(parents=True, exist_ok=True)
            write_text_whole(path, text)
    except OSError as error:
        raise CallerError(f"cannot write the library into {folder}: {error.strerror or error}") from error
