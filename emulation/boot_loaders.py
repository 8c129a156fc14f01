"""Boot loaders of an Arduino, which write the flash when a host asks after a reset: as Debian's package has them."""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Callable, Mapping
from pathlib import Path

from musclewire.errors import CallerError

__all__ = ["BOOT_LOADERS", "boot_loader"]

FOLDER = Path("/usr/share/arduino/hardware/arduino/avr/bootloaders")
PACKAGES = "arduino-core-avr gcc-avr avr-libc binutils-avr"
# Debian's compiler makes 532 bytes of Optiboot, too many for the 512 that an Uno's fuses leave it: its .hex reaches
# beyond the end of the flash. Here it begins where the next larger boot section does, of 1 kB.
OPTIBOOT_START, OPTIBOOT_VERSION_AT = 0x7C00, 0x7FFE
OPTIBOOT_FLAGS = (
    *("-Os", "-mmcu=atmega328p", "-DF_CPU=16000000L", "-DBAUD_RATE=115200", "-DLED_START_FLASHES=3"),
    *("-nostartfiles", "-nostdlib", "-Wl,--relax", f"-Wl,--section-start=.text={OPTIBOOT_START:#x}"),
    f"-Wl,--section-start=.version={OPTIBOOT_VERSION_AT:#x}",
)


def optiboot(folder: Path) -> Path:
    """Compile Optiboot, the loader of an Uno and of a Nano since 2018, and return its .hex."""
    elf, made = folder / "optiboot.elf", folder / "optiboot.hex"
    parts = ("-j", ".text", "-j", ".version", "--set-section-flags", ".version=alloc,load")
    for command in (
        ("avr-gcc", *OPTIBOOT_FLAGS, str(FOLDER / "optiboot/optiboot.c"), "-o", str(elf)),
        ("avr-objcopy", *parts, "-O", "ihex", str(elf), str(made)),
    ):
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode != 0:
            raise CallerError(f"{command[0]} does not build Optiboot: {done.stderr.strip()}")
    return made


# By name; that of a Nano of before 2018 is a file as it is.
BOOT_LOADERS: Mapping[str, Callable[[Path], Path]] = {
    "optiboot": optiboot,
    "atmegaboot": lambda _: FOLDER / "atmega/ATmegaBOOT_168_atmega328.hex",
}


def boot_loader(name: str, folder: Path) -> Path:
    """Return the .hex of a boot loader, made in a folder if need be. Raises CallerError with what is missing."""
    if not FOLDER.is_dir() or shutil.which("avr-gcc") is None:
        raise CallerError(f"boot loaders are missing: apt-get install --no-install-recommends -y {PACKAGES}")
    return BOOT_LOADERS[name](folder)
