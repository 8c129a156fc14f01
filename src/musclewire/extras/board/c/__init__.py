"""The exported C library: its numbers, checks, files, golden vectors and figures."""

from musclewire.extras.board.c.arduino import write_arduino_zip
from musclewire.extras.board.c.library import Library, library_license, library_sources, loop_checksum, write_library

__all__ = ["Library", "library_license", "library_sources", "loop_checksum", "write_arduino_zip", "write_library"]
