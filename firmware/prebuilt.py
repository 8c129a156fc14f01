"""Build the firmware images that ship with musclewire, and their manifest.

    python firmware/prebuilt.py               the images, of the models that are there
    python firmware/prebuilt.py --models      first the models of the simulated wires, firmware/models/*.json, too

One image for each wire of firmware/models on each board that people flash; the wire's limits and model are compiled in.
The same sources and the compilers that the manifest names give the same bytes: a test builds them again.
"""

from __future__ import annotations

import argparse
import hashlib
import sys
import tempfile
from pathlib import Path

from firmware.build import MODELS, TOOLCHAINS, board_description, build, mounted_wire, run, simulated_model, tool

from musclewire.extras.board import FOLDER
from musclewire.sensing import save_model

WIRES = ("paper-100um", "flexinol-0.10-lt")
# File name's end and objcopy's format for each board.
FORMATS = {"arduino-uno": ("hex", "ihex"), "stm32f411": ("bin", "binary")}


def compiler_of(board: str) -> str:
    """Return the first line of what a board's compiler says of its version."""
    return run([tool(TOOLCHAINS[board_description(board)["processor"]], "gcc"), "--version"]).splitlines()[0]


def image_of(board: str, wire: str, folder: Path) -> Path:
    """Build a wire's image for a board into a folder and return its file. Raises CallerError like ``build``."""
    folder.mkdir(parents=True, exist_ok=True)
    elf = build(board, folder, wire=wire)
    suffix, form = FORMATS[board]
    image = folder / f"{board}_{wire}.{suffix}"
    run([tool(TOOLCHAINS[board_description(board)["processor"]], "objcopy"), "-O", form, str(elf), str(image)])
    return image


def entry(board: str, wire: str, image: Path) -> str:
    """Return an image's table of the manifest: what is compiled in, its checksum, its compiler."""
    mounted = mounted_wire(wire)
    return "\n".join(
        [
            "[[image]]",
            f'board = "{board}"',
            f'wire = "{wire}"',
            f'file = "{image.name}"',
            f'sha256 = "{hashlib.sha256(image.read_bytes()).hexdigest()}"',
            f'compiler = "{compiler_of(board)}"',
            f"wire_length_m = {mounted.wire_length}",
            f"shunt_resistance_ohm = {mounted.shunt}",
            f"maximum_voltage_v = {mounted.maximum_voltage}",
            "",
        ]
    )


def main() -> int:
    """Build every image into the package, and write the manifest; the models first, where that is asked for."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--models", action="store_true", help="fit the models of the simulated wires anew")
    if parser.parse_args().models:
        for wire in WIRES:
            save_model(simulated_model(mounted_wire(wire)), MODELS / f"{wire}.json")
    texts = ["# Written by firmware/prebuilt.py: the images next to this file, and what is compiled into them.\n"]
    with tempfile.TemporaryDirectory() as temporary:
        for board in FORMATS:
            for wire in WIRES:
                image = image_of(board, wire, Path(temporary) / board / wire)
                (FOLDER / image.name).write_bytes(image.read_bytes())
                texts.append(entry(board, wire, image))
                print(image.name)
    (FOLDER / "manifest.toml").write_text("\n".join(texts), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
