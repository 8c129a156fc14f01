"""The binary of an FMU for this machine, by the C compiler that is there."""

from __future__ import annotations

import os
import platform
import shlex
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

from musclewire.errors import CallerError, NumericsError

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
        raise CallerError(f"FMI 2.0 has no name for binaries of {sys.platform}: export with --sources-only")
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
            f"{command[0]} cannot compile the FMU for {platform.machine()}: {first}; export with --sources-only and "
            "let the importing tool compile"
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
            "libc6-dev), or export with --sources-only for tools that compile it themselves"
        )
    return [found]
