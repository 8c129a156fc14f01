"""Which compilers and emulators can measure a library, and how they are called.

All are Debian's. The cores are those of Arm's MPS2 boards, which QEMU emulates, and the ATmega328P of an Arduino Uno or
Nano.
"""

from __future__ import annotations

import shutil
from typing import NamedTuple

__all__ = ["FLAGS", "TARGETS", "Target", "missing_tool"]

# -ffp-contract=off is the one flag that results depend on.
FLAGS = ("-Os", "-ffp-contract=off", "-ffunction-sections", "-fdata-sections")
QEMU = ("qemu-system-arm", "qemu-system-arm")
ARM_PACKAGES = "gcc-arm-none-eabi libnewlib-arm-none-eabi"


class Target(NamedTuple):
    """A processor: how to compile for it, and the machine that an emulator has with it."""

    name: str
    compiler: str
    packages: str
    core: tuple[str, ...]
    machine: str
    emulator: str
    emulator_packages: str

    @property
    def size_program(self) -> str:
        """The program of the same toolchain that prints the size of objects."""
        return f"{self.compiler.removesuffix('gcc')}size"


TARGETS = (
    Target(
        "cortex-m3",
        "arm-none-eabi-gcc",
        ARM_PACKAGES,
        ("-std=c99", "-mcpu=cortex-m3", "-mthumb"),
        "mps2-an385",
        *QEMU,
    ),
    Target(
        "cortex-m4f",
        "arm-none-eabi-gcc",
        ARM_PACKAGES,
        ("-std=c99", "-mcpu=cortex-m4", "-mthumb", "-mfloat-abi=hard", "-mfpu=fpv4-sp-d16"),
        "mps2-an386",
        *QEMU,
    ),
    Target(
        "cortex-m7",
        "arm-none-eabi-gcc",
        ARM_PACKAGES,
        ("-std=c99", "-mcpu=cortex-m7", "-mthumb", "-mfloat-abi=hard", "-mfpu=fpv5-d16"),
        "mps2-an500",
        *QEMU,
    ),
    # GNU's C, because only there tables can stay in program memory.
    Target(
        "atmega328p",
        "avr-gcc",
        "gcc-avr avr-libc",
        ("-std=gnu99", "-mmcu=atmega328p"),
        "atmega328p",
        "simavr",
        "simavr",
    ),
)


def missing_tool(program: str, packages: str) -> str:
    """Return the line that installs a program that is missing, "" if it is installed."""
    if shutil.which(program):
        return ""
    return f"{program} is missing: apt-get install --no-install-recommends -y {packages}"
