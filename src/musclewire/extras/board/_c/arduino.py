"""An exported library as the Arduino IDE takes it: one .zip for "Add .ZIP Library".

The form is that of the Arduino library specification, format 1.5: https://arduino.github.io/arduino-cli/latest/library-specification/
"""

from __future__ import annotations

import zipfile
from pathlib import Path
from typing import TYPE_CHECKING

from musclewire.errors import CallerError
from musclewire.signals import write_whole

if TYPE_CHECKING:
    from musclewire.extras.board._c.library import CLibrary

# What belongs to an Arduino library; the tests and the CMake project stay in the folder.
IN_ZIP = ("library.properties", "keywords.txt", "LICENSE", "README.md", "src/", "examples/")
# The same library gives the same bytes, whenever it is written.
NO_DATE = (1980, 1, 1, 0, 0, 0)


def write_arduino_zip(library: CLibrary, path: str | Path) -> Path:
    """Write an exported library as one .zip, which the Arduino IDE adds by Sketch, Include Library.

    Raises CallerError if the file does not end in .zip, or cannot be written.
    """
    path = Path(path)
    if path.suffix != ".zip":
        raise CallerError(f"{path}: the Arduino IDE takes a .zip, end its name so")
    chosen = [name for name in library.files if name.startswith(IN_ZIP)]

    def write(part: Path) -> None:
        with zipfile.ZipFile(part, "w", zipfile.ZIP_DEFLATED) as archive:
            for name in chosen:
                entry = zipfile.ZipInfo(f"{library.name}/{name}", NO_DATE)
                entry.compress_type = zipfile.ZIP_DEFLATED
                archive.writestr(entry, (library.folder / name).read_bytes())

    write_whole(path, write)
    return path
