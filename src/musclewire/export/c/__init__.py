"""The exported C library: its numbers, checks, files, golden vectors and figures."""

from musclewire.export.c.arduino import write_arduino_zip
from musclewire.export.c.library import Library, library_sources, loop_checksum, write_library

__all__ = ["Library", "library_sources", "loop_checksum", "write_arduino_zip", "write_library"]
