"""Compile a function with Numba, with an on-disk cache that cannot go stale.

Numba's own cache notices an edit of the file that defines a function, but not of another file whose function it
calls (numba issue 1833): the old machine code keeps running. Here the cache folder is named by a hash over every
Python source of the package that may hold compiled code, so that an edit anywhere starts a new folder. Parts outside
the core have folders of their own, named by the core's sources and theirs.
"""

from __future__ import annotations

import hashlib
import logging
import os
import sys
import time
from collections.abc import Callable, Mapping
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import Any, TypeVar

import numba
import numpy as np
from numba.core import config, event
from numba.core.registry import CPUDispatcher
from numba.extending import lower_builtin, type_callable

from musclewire.manifest import manifests

numba_config: Any = config  # its options are set at run time, where mypy cannot see them

__all__ = ["COMPILATION", "CompiledCallback", "callback", "compiled", "compiled_inline", "compiled_inner", "row_in"]

# Strict IEEE 754 arithmetic that divides by 0 as NumPy does, and leaves the interpreter free.
OPTIONS: dict[str, Any] = {"error_model": "numpy", "nogil": True}
Function = TypeVar("Function", bound=Callable[..., Any])
ROOMS_WITH_KERNELS = ("physics", "wire", "controllers", "sensing", "rigs/_compiled_loop")
# Of a room of which few files hold kernels only these count, so that an edit of the others costs no compilation.
FILES_WITH_KERNELS = ("rigs/_simulated.py", "random_numbers.py")


class Compilation(event.Listener):
    """How long this process has compiled; the first time it says so, to the logger ``musclewire.compiled``."""

    def __init__(self) -> None:
        """Nothing has been compiled yet."""
        self.total_s = 0.0
        self._depth = 0
        self._began_s = 0.0

    def on_start(self, event: Any) -> None:  # noqa: ARG002
        """Note the start; a kernel is compiled while one that calls it is."""
        if self._depth == 0:
            if self.total_s == 0.0:
                kept = (
                    "once: later runs take it from the cache"
                    if cache_folder()
                    else "in every run: no cache can be written"
                )
                logging.getLogger(__name__).info("compiling wire and controllers to machine code, %s", kept)
            self._began_s = time.perf_counter()
        self._depth += 1

    def on_end(self, event: Any) -> None:  # noqa: ARG002
        """Add what the outermost took."""
        self._depth -= 1
        if self._depth == 0:
            self.total_s += time.perf_counter() - self._began_s


COMPILATION = Compilation()
event.register("numba:compile", COMPILATION)  # type: ignore[no-untyped-call]


@cache
def kernel_source_hash() -> str:
    """Return a short hash over every source file that may hold compiled code."""
    package = Path(__file__).parent
    in_rooms = (path for room in ROOMS_WITH_KERNELS for path in sorted((package / room).rglob("*.py")))
    files = (*in_rooms, *(package / name for name in FILES_WITH_KERNELS))
    return hash_over({path.relative_to(package).as_posix(): path for path in files})


def hash_over(files: Mapping[str, Path], before: str = "") -> str:
    """Return a short hash over the names and contents of files, and over a hash of what they call."""
    digest = hashlib.sha256(before.encode())
    for name, path in files.items():
        digest.update(name.encode())
        digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


@cache
def part_source_hash(part: str) -> str:
    """Return a short hash over the kernels of a part outside the core, and those of the core, which they call."""
    modules = next(manifest.kernels for manifest in manifests() if manifest.name == part)
    found = {module: find_spec(module) for module in modules}
    files = {module: Path(spec.origin) for module, spec in found.items() if spec is not None and spec.origin}
    return hash_over(files, kernel_source_hash())


def part_of(module: str) -> str | None:
    """Return the part outside the core whose kernels a module holds, None for any other module.

    A kernel of the core asks no manifest: it is compiled while rooms are imported, which a manifest may import, too.
    """
    if module.startswith("musclewire.") and not module.startswith("musclewire.extras."):
        return None
    return next((manifest.name for manifest in manifests() if module in manifest.kernels), None)


def cache_root() -> Path:
    """Return the user's cache folder for compiled kernels (``NUMBA_CACHE_DIR`` takes precedence if it is set)."""
    if numba_config.CACHE_DIR:
        return Path(numba_config.CACHE_DIR)
    if sys.platform == "win32":
        base = Path(os.environ.get("LOCALAPPDATA", Path.home() / "AppData" / "Local"))
    else:
        base = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    return base / "musclewire" / "kernels"


@cache
def cache_folder(part: str | None = None) -> str | None:
    """Return this version's kernel folder, apart for each part outside the core; None if nothing can be written."""
    folder = cache_root() / (kernel_source_hash() if part is None else part_source_hash(part))
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError:
        return None
    return str(folder) if os.access(folder, os.W_OK) else None


class InnerFunction(CPUDispatcher):
    """A compiled function without entries of its own for Python and C, which take a third of the time to compile.

    Nor is it compiled again for each whole number that its callers name as a constant, as Numba's own would be.
    """

    def get_call_template(self, args: Any, kws: Any) -> Any:
        """Return what Numba takes a call's type from: that of any whole number, for a constant too."""
        plain: Any = numba.types.unliteral
        return super().get_call_template(tuple(map(plain, args)), {name: plain(kind) for name, kind in kws.items()})

    def __call__(self, *arguments: Any) -> Any:
        """Call it from Python all the same, through a compiled function that is made for this: for tests and plots."""
        return entry_to(self)(*arguments)


@cache
def entry_to(function: InnerFunction) -> Any:
    """Return a compiled function that Python can call and that calls nothing but this one."""

    def entry(*arguments: Any) -> Any:
        return function(*arguments)

    return numba.njit(**OPTIONS)(entry)


def _compile(function: Function, *, inner: bool = False, **options: Any) -> Function:
    """Return the function compiled by Numba, with this version's cache folder."""
    if numba_config.DISABLE_JIT:
        return function
    folder = cache_folder(part_of(function.__module__))
    before = numba_config.CACHE_DIR
    # Numba chooses the folder while it decorates, so the setting is ours for that moment only.
    numba_config.CACHE_DIR = folder or before
    try:
        if inner:
            options |= {"nopython": True, "no_cpython_wrapper": True, "no_cfunc_wrapper": True}
            dispatcher: Any = InnerFunction(function, targetoptions=OPTIONS | options)
            if folder is not None:
                dispatcher.enable_caching()
        else:
            dispatcher = numba.njit(cache=folder is not None, **OPTIONS, **options)(function)
    finally:
        numba_config.CACHE_DIR = before
    return dispatcher


def compiled(function: Function) -> Function:
    """Compile a function on its first call, in strict IEEE 754 arithmetic: the same digits as plain Python.

    It releases the global interpreter lock while it runs, so that threads can run several wires at a time.

    Parameters
    ----------
    function
        A function of numbers, arrays and tuples, as Numba's nopython mode takes.

    Returns
    -------
    The function, compiled; ``.py_func`` is the plain one.
    """
    return _compile(function)


def compiled_inner(function: Function) -> Function:
    """Compile as :func:`compiled` does, in two thirds of the time, for compiled callers only.

    Python can call it, too, but each type of arguments is then compiled once more.
    """
    return _compile(function, inner=True)


def compiled_inline(function: Function) -> Function:
    """Compile as :func:`compiled_inner`, inlined in each compiled caller: only so are loops over wires vectorised."""
    return _compile(function, inner=True, forceinline=True)


class CompiledCallback(numba.types.WrapperAddressProtocol):
    """A compiled function as a value that compiled code takes and calls, whichever function of its signature it is.

    A function that takes a callback is compiled once for a signature and not once for each function that it is given.
    """

    def __init__(self, address: int, signature: Any) -> None:
        """Keep the address with its signature."""
        self._address, self._signature = address, signature

    def __wrapper_address__(self) -> int:
        """Return the address, as Numba asks for it."""
        return self._address

    def signature(self) -> Any:
        """Return the signature, as Numba asks for it."""
        return self._signature


def row_in(numbers: Any, layout: Any) -> Any:
    """Return the row, a view, with which an array of floats begins, which must be long enough and contiguous.

    For ticks, whose arrays are plain: in compiled code it costs nothing, where a view of NumPy takes as long to compile
    as the tick.
    """
    return np.ndarray(1, layout, numbers)[0]


@type_callable(row_in)
def type_of_row_in(_context: Any) -> Callable[..., Any]:
    """Return how Numba finds the type of what ``row_in`` returns."""
    return lambda numbers, layout: layout.dtype if isinstance(numbers, numba.types.Array) else None


@lower_builtin(row_in, numba.types.Array, numba.types.DType)  # type: ignore[no-untyped-call, untyped-decorator]
def lowered_row_in(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    """Return a row as Numba keeps it: the address of its first number."""
    array = context.make_array(signature.args[0])(context, builder, arguments[0])
    return builder.bitcast(array.data, context.get_value_type(signature.return_type))


@cache
def callback(function: Any, n_arrays: int) -> Any:
    """Return a compiled function of one-dimensional contiguous arrays of floats, which returns nothing, as a callback.

    The same object for the same arguments. With compilation off (``NUMBA_DISABLE_JIT``) the function itself, which
    plain Python calls as well. Raises TypeError for a function that is not compiled or returns something.
    """
    if numba_config.DISABLE_JIT:
        return function
    arrays = (numba.types.float64[::1],) * n_arrays
    if not hasattr(function, "get_compile_result") or isinstance(function, InnerFunction):
        raise TypeError(f"{function!r} is not compiled: decorate it with musclewire.compiled.compiled")
    signature = numba.types.none(*arrays)
    function.compile(arrays)
    result = function.overloads[arrays]
    if result.signature.return_type != numba.types.none:
        raise TypeError(f"{function.__name__} returns {result.signature.return_type}, not nothing")
    return CompiledCallback(result.library.get_pointer_to_function(result.fndesc.llvm_cfunc_wrapper_name), signature)
