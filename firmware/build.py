"""Build the reference firmware for a board: export the model as C, compile, link, print the size.

    python firmware/build.py --board mps2-an386
    python firmware/build.py --board arduino-uno --wire flexinol-0.15-lt
    python firmware/build.py --board arduino-uno --model model.json --wire wire.toml -o build

A wire by its name is 140 mm as a V, with the shunt, voltages and pretension of `musclewire simulate --table`. A wire
file describes another, with the keys of a rig file (firmware/models/paper-100um.toml is one). Without a model the
wire's own in firmware/models is taken, or one is fitted on the simulated wire.
The compilers are Debian's: gcc-arm-none-eabi with libnewlib-arm-none-eabi, gcc-avr with avr-libc.
"""

from __future__ import annotations

import argparse
import re
import shutil
import subprocess
import sys
import tomllib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from musclewire.controllers import DriveLimits, Event
from musclewire.errors import CallerError, MusclewireError, argument, nearest_hint
from musclewire.experiment import characterize, staircase_within
from musclewire.extras.board import BOARD_NAMES, settings_in_c, write_library
from musclewire.identify import check_made_for, fit
from musclewire.parameters import validated
from musclewire.rigs import MountedWire, numbers_given, open_rig, own_circuit
from musclewire.sensing import PAPER_ESTIMATOR, SensingModel, load_model

FIRMWARE = Path(__file__).resolve().parent
MODELS = FIRMWARE / "models"
WIRE = "paper-100um"
# How a wire of the catalogue is mounted: as the paper's.
LENGTH_M, LEGS = 0.14, 2
# What a simulated rig has in common with a board's wire and circuit.
CIRCUIT = (
    "wire_length_m",
    "legs",
    "shunt_resistance_ohm",
    "sense_voltage_v",
    "maximum_voltage_v",
    "drive_amplitude_v",
    "pretension_n",
)
EXPIRY_MS = 250
# How lines of text show what a model estimates: what a label ends in, and how much larger the number is than in SI.
TEXT_UNITS = {"strain": ("pct", 100.0), "displacement": ("mm", 1000.0), "force": ("n", 1.0)}
# How a linker says that a program does not fit.
OVERFLOW = re.compile(r"region `text' overflowed by (\d+) bytes")
WARNINGS = ["-Wall", "-Wextra", "-Wconversion", "-Wshadow", "-Wno-unknown-pragmas", "-Wno-override-init", "-Werror"]
COMMON = ["-std=gnu99", "-ffp-contract=off", "-ffunction-sections", "-fdata-sections", *WARNINGS]
M4F = ["-mcpu=cortex-m4", "-mthumb", "-mfloat-abi=hard", "-mfpu=fpv4-sp-d16"]
UNO = ["-mmcu=atmega328p", "-DF_CPU=16000000UL"]


@dataclass(frozen=True)
class Toolchain:
    """The compiler of a kind of processor, the packages that install it and its options."""

    prefix: str
    packages: str
    compile: tuple[str, ...]
    link: tuple[str, ...]


TOOLCHAINS = {
    "cortex-m4f": Toolchain(
        "arm-none-eabi-",
        "gcc-arm-none-eabi libnewlib-arm-none-eabi",
        (*M4F, "-O2", *COMMON),
        (*M4F, "-nostartfiles", "--specs=nosys.specs", "--specs=nano.specs", "-Wl,--gc-sections"),
    ),
    "avr5": Toolchain(
        "avr-", "gcc-avr avr-libc binutils-avr", (*UNO, "-Os", *COMMON), (*UNO, "-Wl,--gc-sections", "-lm")
    ),
}


def boards() -> list[str]:
    """Return the names of the boards with a hardware layer."""
    return sorted(file.parent.name for file in (FIRMWARE / "boards").glob("*/circuit.toml"))


def board_name(given: str) -> str:
    """Return a board's own name for one that people use (``nano``), and any other name as it is."""
    return BOARD_NAMES.get(given, given)


def board_description(board: str) -> dict[str, Any]:
    """Return a board's numbers (circuit.toml). Raises CallerError for an unknown board."""
    if board not in boards():
        raise CallerError(f"there is no board '{board}'{nearest_hint(board, boards())}")
    return tomllib.loads((FIRMWARE / "boards" / board / "circuit.toml").read_text(encoding="utf-8"))


def mounted_wire(wire: str | Path) -> MountedWire:
    """Return what hangs on a board: by a wire file, by a file of firmware/models, or by the name of any known wire.

    Raises CallerError naming file and key, or for an unknown wire.
    """
    given = Path(wire)
    path = given if given.suffix == ".toml" else MODELS / f"{wire}.toml"
    if path.is_file():
        return validated(MountedWire, tomllib.loads(path.read_text(encoding="utf-8")), f"wire file {path}")
    if given.suffix == ".toml":
        raise CallerError(f"there is no wire file {path}: give one with the keys of firmware/models/paper-100um.toml")
    own = own_circuit(str(wire), wire_length_m=LENGTH_M, legs=LEGS)
    return MountedWire(
        wire=str(wire),
        wire_length=LENGTH_M,
        legs=LEGS,
        shunt=own.shunt_ohm,
        sense_voltage=own.sense_voltage_v,
        pretension=own.pretension_n,
    )


def model_of(wire: MountedWire, model_file: Path | None) -> SensingModel:
    """Return the model of a file, else that of firmware/models for this wire, else one fitted on the simulated wire."""
    if model_file is not None:
        return load_model(model_file)
    path = MODELS / f"{wire.wire}.json"
    if path.is_file() and wire.wire_length == LENGTH_M:
        return load_model(path)
    return simulated_model(wire)


def simulated_model(wire: MountedWire) -> SensingModel:
    """Return the model that a slow loop of the simulated wire gives, on the circuit of the mounted one."""
    circuit = {name: value for name, value in numbers_given(wire).items() if name in CIRCUIT}
    with open_rig("simulated", wire=wire.wire, **circuit) as rig:
        return fit(characterize(rig))


def ranges_v(description: dict[str, Any]) -> tuple[float, float]:
    """Return the largest node and shunt voltage that a board's channels measure."""
    full = description["converter_range_v"]
    return full / description["divider_share"], full / description["shunt_gain"]


def require_fit(board: str, description: dict[str, Any], wire: MountedWire) -> None:
    """Raise CallerError if a wire needs more than a board puts out."""
    if wire.maximum_voltage > description["output_range_v"]:
        raise CallerError(
            f"board {board} gives {description['output_range_v']:g} V at most and the wire file allows "
            f"{wire.maximum_voltage:g} V: lower maximum_voltage"
        )


def text_constants(model: SensingModel, wire: MountedWire) -> dict[str, str]:
    """Return what lines of text say: unit and range of the model's quantity, the protection's events by number."""
    unit, scale = TEXT_UNITS[model.quantity]
    lowest, highest = (scale * edge for edge in (model.quantity_min, model.quantity_max))
    names = {event.value: event.name.lower() for event in Event}
    listed = "".join(names.get(number, "") + "\\n" for number in range(max(names) + 1))
    return {
        "PLOT_UNIT": f'"{unit}"',
        "PLOT_SCALE": f"{scale!r}f",
        "PLOT_RANGES": f'"target {lowest:.2f} to {highest:.2f} {unit}, drive 0 to {wire.maximum_voltage:g} V, 120 s"',
        "EVENT_NAMES": f'"{listed}"',
    }


def board_constants(board: str, description: dict[str, Any], model: SensingModel, wire: MountedWire) -> str:
    """Return the text of board_constants.h."""
    node_v, shunt_v = ranges_v(description)
    full_code = (2 ** description["converter_bits"] - 1) * description.get("readings_per_tick", 1)
    span = model.quantity_max - model.quantity_min
    tick_s = description["tick_period_s"]
    staircase = staircase_within(model)
    numbers = {
        "BOARD_NAME": f'"{description["name"]}"',
        "WIRE_NAME": f'"{wire.known_wire().name}"',
        "TICK_PERIOD_US": f"{round(1e6 * tick_s)}u",
        "TICK_S": f"{tick_s!r}f",
        "CONTROL_TICKS": f"{round(description['control_period_s'] / tick_s)}u",
        "EXPIRY_MS": f"{EXPIRY_MS}u",
        "CONVERTER_FULL_CODE": f"{full_code}u",
        "NODE_RANGE_V": f"{node_v!r}f",
        "SHUNT_RANGE_V": f"{shunt_v!r}f",
        "OUTPUT_FULL_CODE": f"{2 ** description['output_bits'] - 1}u",
        "OUTPUT_RANGE_V": f"{description['output_range_v']!r}f",
        # Below the model's range a target only lets the wire cool; above it the loop would heat without end.
        "TARGET_LOWEST": f"{model.quantity_min - span!r}f",
        "TARGET_HIGHEST": f"{model.quantity_max!r}f",
        "BOARD_HAS_BUTTON": f"{int(description['has_button'])}",
        "BOARD_HAS_KNOB": f"{int(description['has_knob'])}",
        "DRIVE_AMPLITUDE_V": f"{wire.drive_amplitude!r}f",
        "STAIRCASE": f"{{{', '.join(f'{level!r}f' for level in staircase.levels)}}}",
        "STAIRCASE_TICKS": f"{round(staircase.hold_s / tick_s)}u",
        **text_constants(model, wire),
    }
    lines = [f"#define MW_{name} {value}" for name, value in numbers.items()]
    start = f"/* Written by firmware/build.py from boards/{board}/circuit.toml, the model and the wire file. */\n"
    guard = "MW_BOARD_CONSTANTS_H"
    return f"{start}#ifndef {guard}\n#define {guard}\n\n" + "\n".join(lines) + "\n\n#endif\n"


def write_sources(
    board: str,
    folder: Path,
    *,
    wire: str | Path = WIRE,
    model_file: Path | None = None,
    estimator: str | None = None,
    controller: str | None = None,
) -> SensingModel:
    """Write the exported controller and the board's constants into a folder; return the model. Raises CallerError.

    Without names of estimator and controller they are the board's own, by what its processor holds.
    """
    description, mounted = board_description(board), mounted_wire(wire)
    require_fit(board, description, mounted)
    model = model_of(mounted, model_file)
    # The limits are the wire's: with another wire's they would let too much current through.
    check_made_for(model, mounted.facts(), f"wire {mounted.wire}", "give your wire by --wire, or fit a model")
    node_v, shunt_v = ranges_v(description)
    limits = mounted.protection_limits(
        wire_range_v=node_v, shunt_range_v=shunt_v, readings_noisy=description.get("readings_noisy", True)
    )
    constants = board_constants(board, description, model, mounted)
    drive = DriveLimits(mounted.sense_voltage, mounted.maximum_voltage)
    settings = settings_in_c(
        model,
        controller or description["controller"],
        sample_period_s=description["control_period_s"],
        file=model_file,
    )
    write_library(model, settings, drive, limits, folder, estimator=estimator or description["estimator"])
    (folder / "src" / "board_constants.h").write_text(constants, encoding="utf-8")
    return model


def tool(chain: Toolchain, name: str) -> str:
    """Return the path of a tool. Raises CallerError with the line that installs it."""
    path = shutil.which(chain.prefix + name)
    if path is None:
        raise CallerError(
            f"{chain.prefix}{name} is missing: apt-get install --no-install-recommends -y {chain.packages}"
        )
    return path


def run(command: Sequence[str]) -> str:
    """Run a tool and return its output. Raises CallerError with its messages if it fails."""
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise CallerError(f"{Path(command[0]).name} failed:\n{done.stderr.strip()}")
    return done.stdout


def build(
    board: str,
    folder: Path,
    *,
    model_file: Path | None = None,
    wire: str | Path = WIRE,
    estimator: str | None = None,
    controller: str | None = None,
    options: Sequence[str] = (),
) -> Path:
    """Build the firmware and return its ELF file. ``options`` go to the compiler, such as ``-DMW_STANDALONE``.

    Raises CallerError for a wrong board, model or wire, a missing compiler, or code that does not compile.
    """
    description = board_description(board)
    chain = TOOLCHAINS[description["processor"]]
    compiler = tool(chain, "gcc")
    write_sources(board, folder, wire=wire, model_file=model_file, estimator=estimator, controller=controller)
    places = [FIRMWARE / "src", FIRMWARE / "boards" / board, folder / "src"]
    sources = [file for place in places for file in sorted(place.glob("*.c"))]
    includes = [f"-I{place}" for place in places]
    elf = folder / f"musclewire-{board}.elf"
    script = FIRMWARE / "boards" / board / "link.ld"
    link = [*chain.link, "-T", str(script)] if script.exists() else list(chain.link)
    objects = []
    for number, source in enumerate(sources):
        objects.append(str(folder / f"{number:02}-{source.stem}.o"))
        run([compiler, *chain.compile, *includes, *options, "-c", str(source), "-o", objects[-1]])
    try:
        run([compiler, *objects, *link, "-o", str(elf)])
    except CallerError as error:
        if over := OVERFLOW.search(str(error)):
            raise CallerError(
                f"with the estimator {estimator or description['estimator']} the firmware is {over[1]} bytes too large "
                f"for board {board}: give " + argument("estimator", PAPER_ESTIMATOR)
            ) from None
        raise
    return elf


def size_of(board: str, elf: Path) -> str:
    """Return the lines that the compiler's ``size`` prints of an ELF file."""
    return run([tool(TOOLCHAINS[board_description(board)["processor"]], "size"), str(elf)])


def main() -> int:
    """Build as the command line says; an error is one line on stderr and the exit code."""
    parser = argparse.ArgumentParser(description="Build the reference firmware for a board.")
    parser.add_argument("--board", default="mps2-an386", help=f"one of: {', '.join(boards())}")
    parser.add_argument("--model", type=Path, default=None, help="sensing model, as musclewire fit writes it")
    parser.add_argument("--wire", default=WIRE, help="the wire on the board: a name of the catalogue, or a file (TOML)")
    parser.add_argument("--estimator", default=None, help="filter or polynomial; else what the board's flash holds")
    parser.add_argument("--controller", default=None, help="inverse-model, the boards' own, or the paper's fuzzy-pid")
    parser.add_argument("-o", "--output", type=Path, default=None, help="folder; firmware/build/BOARD without it")
    parser.add_argument("--standalone", action="store_true", help="closes the loop by itself, started by a button")
    parser.add_argument(
        "--staircase", action="store_true", help="so along the paper's staircase, on a board with a knob, too"
    )
    parser.add_argument(
        "--serial-plotter", action="store_true", help="begins with lines of text for a serial monitor and plotter"
    )
    parser.add_argument(
        "--fault-injection", action="store_true", help="for tests: include the command that injects faults"
    )
    given = parser.parse_args()
    given.board = board_name(given.board)
    folder = given.output or FIRMWARE / "build" / given.board
    flags = {
        "-DMW_STANDALONE": given.standalone or given.staircase,
        "-DMW_STAIRCASE_ALONE": given.staircase,
        "-DMW_FAULT_INJECTION": given.fault_injection,
        "-DMW_TEXT_AT_START": given.serial_plotter,
    }
    options = [flag for flag, wanted in flags.items() if wanted]
    try:
        folder.mkdir(parents=True, exist_ok=True)
        elf = build(
            given.board,
            folder,
            model_file=given.model,
            wire=given.wire,
            estimator=given.estimator,
            controller=given.controller,
            options=options,
        )
        print(size_of(given.board, elf), end="")
    except MusclewireError as error:
        print(f"error: {error}", file=sys.stderr)
        return error.exit_code
    print(f"built {elf}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
