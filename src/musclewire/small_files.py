"""Files that hold settings and not recordings: read by path, none larger than 1 MB; and tables written as TOML."""

from __future__ import annotations

import json
import re
import tomllib
from collections import Counter
from collections.abc import Iterable, Mapping
from math import isfinite
from pathlib import Path
from typing import Any

from musclewire.errors import CallerError

__all__ = ["json_of", "read_small", "read_toml", "toml_of", "toml_text", "toml_value"]

# A sensing model with all its samples takes 200 kB; a device file such as /dev/zero has no end.
MAX_BYTES = 1_000_000
# What TOML promises to keep of a whole number; longer ones fit into no number of a wire either.
MAX_WHOLE = 2**63


def read_small(path: Path, what: str, instead: str = "") -> str:
    """Return the text of a file called ``what`` in messages; ``instead`` ends that about a missing one."""
    try:
        with path.open("rb") as file:
            data = file.read(MAX_BYTES + 1)
    except FileNotFoundError:
        raise CallerError(f"there is no {what} {path}" + instead) from None
    except OSError as error:
        raise CallerError(f"{what} {path} cannot be read: {error.strerror or error}") from None
    except ValueError as error:  # a path with a null character
        raise CallerError(f"{what} {str(path)!r} cannot be read: {error}") from None
    if len(data) > MAX_BYTES:
        raise CallerError(f"{what} {path} is larger than {MAX_BYTES} bytes: this is none, name another file")
    try:
        return data.decode("utf-8")
    except UnicodeDecodeError as error:
        raise CallerError(f"{what} {path} cannot be read: it is no UTF-8 text ({error.reason})") from None


def read_toml(path: Path, what: str, instead: str = "") -> dict[str, Any]:
    """Return the tables of a TOML file, as :func:`read_small` and :func:`toml_of` do."""
    return toml_of(read_small(path, what, instead), f"{what} {path}")


def toml_of(text: str, where: str) -> dict[str, Any]:
    """Return a TOML text as tables. Raises CallerError for what is none, nested too deeply, or has endless numbers."""
    try:
        # Universal newlines, as a file that is opened as text has them.
        tables = tomllib.loads(text.replace("\r\n", "\n").replace("\r", "\n"))
        require_plain(tables.values(), where)
    except RecursionError:
        raise CallerError(f"{where} cannot be read: its values are nested too deeply to be meant") from None
    except tomllib.TOMLDecodeError as error:
        raise CallerError(f"{where} cannot be read: {toml_problem(error)}") from None
    except ValueError as error:
        if isinstance(error, CallerError):
            raise
        raise CallerError(f"{where} cannot be read: {first_words(error)}") from None
    return tables


def json_of(text: str | bytes, where: str) -> Any:
    """Return what a JSON text says; CallerError for a key given twice, NaN, an infinity or deep nesting."""

    def object_of(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
        found = dict(pairs)
        if len(found) < len(pairs):
            twice, _ = Counter(key for key, _ in pairs).most_common(1)[0]
            raise ValueError(f"the key {twice[:60]!r} is there twice")
        return found

    def finite(digits: str) -> float:
        number = float(digits)
        return number if isfinite(number) else refused(digits)

    def refused(name: str) -> Any:
        raise ValueError(f"{name[:60]} is not finite")

    try:
        text = text if isinstance(text, str) else text.decode("utf-8")
        found = json.loads(text, object_pairs_hook=object_of, parse_constant=refused, parse_float=finite)
        require_plain([found], where)
    except RecursionError:
        raise CallerError(f"{where}: no valid JSON (nested too deeply to be meant)") from None
    except ValueError as error:
        if isinstance(error, CallerError):
            raise
        raise CallerError(f"{where}: no valid JSON ({first_words(error)})") from None
    return found


def require_plain(values: Iterable[Any], where: str) -> None:
    """Raise CallerError for a whole number of more than 64 bits, ValueError for half a letter, however deep it is."""
    for value in values:
        if isinstance(value, int) and not -MAX_WHOLE <= value < MAX_WHOLE:
            raise CallerError(f"{where} has a whole number beyond 64 bits: write it as a smaller one, or as 1.5e30")
        if isinstance(value, str):
            value.encode("utf-8")
        if isinstance(value, Mapping):
            require_plain([*value, *value.values()], where)
        elif isinstance(value, list):
            require_plain(value, where)


def toml_problem(error: Exception) -> str:
    """Return what is wrong with a TOML text; its reader calls a quote that is left open an illegal end of line."""
    text = str(error)
    line = re.search(r"at line (\d+)", text)
    if line and "Illegal character '\\n'" in text:
        return f"a quote is not closed in line {line[1]}"
    return " ".join(text.split())


def first_words(error: Exception) -> str:
    """Return an error as one line of at most 160 characters; of a number of too many digits in words of our own."""
    text = " ".join(str(error).split())
    return "it has a number of thousands of digits" if "int_max_str_digits" in text else text[:160]


def toml_text(content: Mapping[str, Any], place: str = "") -> str:
    """Return nested tables as TOML, without what is None or an empty text; numbers keep every bit."""
    stated = {key: value for key, value in content.items() if value is not None and value != ""}
    own = [f"{key} = {toml_value(value)}\n" for key, value in stated.items() if not isinstance(value, Mapping)]
    head = [f"[{place}]\n"] if place and own else []
    tables = (
        toml_text(value, f"{place}.{key}" if place else key)
        for key, value in stated.items()
        if isinstance(value, Mapping)
    )
    return "\n".join(filter(None, ("".join(head + own), *tables)))


def toml_value(value: Any) -> str:
    """Return a text, a number, a yes or no, or a list of them as TOML."""
    if isinstance(value, (str, bool)):
        # JSON's texts are TOML's, but for the character that JSON leaves as it is.
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, (list, tuple)):
        return f"[{', '.join(map(toml_value, value))}]"
    return repr(float(value) if isinstance(value, float) else value)
