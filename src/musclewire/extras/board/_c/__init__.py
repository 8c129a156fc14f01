"""The exported C library: its numbers, checks, files, golden vectors and figures."""

from musclewire.extras.board._c.arduino import write_arduino_zip
from musclewire.extras.board._c.library import (
    CLibrary,
    library_license,
    library_sources,
    loop_checksum,
    write_library,
)

__all__ = ["CLibrary", "library_license", "library_sources", "loop_checksum", "write_arduino_zip", "write_library"]
