"""Started at power-on, after boot.py: nothing runs that is not whole, and then the loop."""

import hashlib
import sys

MIN_VERSION = (1, 22)
HASHES = {}  # SHA-256 of every other file, as it was written


def refusal():
    """Return why nothing is started, "" if all is well."""
    if sys.implementation.version[:2] < MIN_VERSION:
        return "MicroPython 1.22 or newer is needed: put it on the board"
    for name, digest in HASHES.items():
        try:
            with open(name, "rb") as file:
                found = hashlib.sha256(file.read()).digest()
        except OSError:
            found = b""
        if found != digest:
            return name + " is not as it was written: copy all files again"
    return ""


reason = refusal()
if reason:
    print(reason)
else:
    import musclewire_run

    musclewire_run.start()
