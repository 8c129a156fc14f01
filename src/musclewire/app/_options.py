"""Every option of the core's commands and of several parts, defined once: its name, its unit, and what it means.

A command says which options it has, with which type and default; name and help come from here. The same name means the
same in all commands (``tests/app/test_command_line.py``).
"""

from __future__ import annotations

import re
import shlex
from collections.abc import Mapping
from math import inf
from typing import Annotated, Any, NamedTuple, overload

import typer

from musclewire.app._completion import (
    complete_controllers,
    complete_estimators,
    complete_rigs,
    complete_rule_bases,
    complete_wires,
)
from musclewire.errors import Argument, CallerError

# A number without a unit.
BARE = re.compile(r"\s*[+-]?[\d.]+(?:[eE][+-]?\d+)?\s*")
EXAMPLES = {
    "--column": "NAME=HEADER or NAME=HEADER:UNIT, as wire_voltage_v='Vw:V'",
    "--set": "NAME=VALUE, as pretension_n='1.9 N'",
    "--mark": "NAME=POSITION, as cold='0 mm', hot='2.6 mm' or stop='2 mm'",
}


class OptionQuantity(NamedTuple):
    """What an option with a number and a unit becomes: the SI unit, and the smallest and largest value in it."""

    unit: str
    low: float = -inf
    high: float = inf


class Offered(NamedTuple):
    """Annotation of a command's parameter: a tuple of dataclasses of options, as parts offer them."""

    kind: str  # field of their manifests that names them


class OptionDefinition(NamedTuple):
    """What an option is called and means."""

    names: tuple[str, ...]
    help: str
    how: Mapping[str, Any]  # for typer: smallest and largest number, how its value is shown
    quantity: OptionQuantity | None = None  # None if its value is no number with a unit


# Options that are not called as the argument in Python, and endings of arguments that name a unit.
CALLED = {"on": "--join", "shunt_resistance_ohm": "--shunt"}
WITH_UNIT = re.compile("_(n|m|s|v|a|k|ohm)$")
# A larger number is a slip of the pen, whose command would never end:
MAX_COUNT = 100_000  # loops or cycles
MAX_CORES = 4096  # processes, threads or processor cores
# What may be stated as a wire's temperature [K]; rigs check the same.
COLDEST_K = 200.0  # a smaller number is one in degrees Celsius
MELTING_K = 1583.0  # of nitinol
# All options by their first name.
OPTIONS: dict[str, OptionDefinition] = {}


def option(*names: str, help: str, **how: Any) -> Any:
    """Define an option; ``how`` goes to typer: smallest and largest number, how its value is shown."""
    OPTIONS[names[0]] = OptionDefinition(names, help, how)
    return own_help(names[0], help)


def quantity(name: str, unit: str, help: str, low: float = -inf, high: float = inf) -> Any:
    """Define an option whose value is a number with a unit."""
    OPTIONS[name] = OptionDefinition((name,), help, {"metavar": "QUANTITY"}, OptionQuantity(unit, low, high))
    return own_help(name, help)


def own_help(name: str, help: str, **how: Any) -> Any:
    """Return a defined option with the help of one command, and ``how``, where the usual ones do not hold."""
    return typer.Option(*OPTIONS[name].names, help=help, **{**OPTIONS[name].how, **how})


# What is written, and how it is shown.
option("--output", "-o", help="File or folder to write, as each command says of its own.")
OVERWRITE = option("--overwrite", help="Replace what is already there.")
PLOT = option("--plot", help="Figure to write (.svg, .png, .pdf).")
PLOT_STYLE = option("--plot-style", help="Size and fonts of the figure: screen, slides, or a journal's column.")
REPORT = option("--report", help="Page to write (.html); by default next to the output.")
JSON = option("--json", help="Print one JSON document on stdout.")
BIBTEX = option("--bibtex", help="Print entries of BibTeX.")
LIST = option("--list", help="List the names that can be given, and exit.")

# Rigs and their clocks.
SEED = option("--seed", help="Seed of everything random: the same seed, the same numbers.", min=0, max=10**18)
BEYOND_CATALOGUE = option(
    "--beyond-catalogue", help="Confirm lengths, voltages and limits that no wire of the catalogue has or survives."
)
REAL_TIME = option("--real-time", help="Pace a simulated rig by the clock.")
CLOCK_SPEED = option("--clock-speed", help="With --real-time: run so many times as fast as the clock, 0.01 to 1000.")
REAL_TIME_PRIORITY = option(
    "--real-time-priority", help="On Linux: run before all ordinary programs, with memory locked."
)
CPU = option("--cpu", help="On Linux: keep the loop on this processor core.", min=0, max=MAX_CORES)
WIRE_TEMPERATURE = quantity(
    "--wire-temperature",
    "K",
    "How warm a real rig's wire is, as '22 degC', if that is not remembered. Without it such a wire rests first.",
    COLDEST_K,
    MELTING_K,
)
HOLD = quantity("--hold", "s", "Time for which the sense voltage is held, as '5 s'.", 1.0, 3600.0)
METER_WIRE = quantity("--meter-wire", "V", "Reading of a meter across the wire at the sense voltage.")
METER_SHUNT = quantity("--meter-shunt", "V", "Reading of a meter across the shunt at the sense voltage.")
WRITE = option("--write", help="Write offsets, and gains by the meter, into the rig file.")
RIG = option(
    "--rig",
    help="Rig whose circuit and limits are taken: 'simulated', or a rig file of kind simulated or serial.",
    autocompletion=complete_rigs,
)

# The slow sine and what is compared by it.
AMPLITUDE = quantity("--amplitude", "V", "Amplitude of the slow sine, as '3.2 V'.")
UNTIL_LEVEL = option("--until-level", help="Raise the amplitude until the resistance levels off or a limit is met.")
NO_MINOR_LOOP = option("--no-minor-loop", help="Leave out the minor loop after the cycles: it takes about one more.")
PERIOD = quantity("--period", "s", "Period of the slow sine, as '90 s'.", 1.0, 86400.0)
CYCLES = option("--cycles", help="Cycles of the slow sine; the last is analysed.", min=1)
MAX_CYCLES = option("--max-cycles", help="Stop after this many cycles at the latest.", min=2, max=MAX_COUNT)
AT = quantity("--at", "N", "A pretension to try, as '1.9 N'. Repeatable.")
QUANTITY = option("--quantity", help="Quantity sensed from resistance: strain, displacement or force.")
FOLLOWED_QUANTITY = own_help("--quantity", "Quantity of the reference: strain, displacement or force.")
COMPARED_QUANTITY = own_help(
    "--quantity", "Quantity for which the best pretension is named: strain, displacement or force."
)

# The closed loop.
REFERENCE = option(
    "--reference",
    help="'staircase', steps as '2.5 mm to 6 mm by 0.5 mm', each for 6 s or as '... by 0.5 mm for 20 s', or a file "
    "with the targets over time.",
)
KNOWN_STIFFNESS = quantity(
    "--known-stiffness",
    "N/m",
    "Known stiffness of the load, as '588.6 N/m': gives force from a model of strain.",
)
ESTIMATOR = option(
    "--estimator",
    help="Estimator by name: computes strain, displacement or force from voltages. Default: filter; polynomial (the "
    "paper's) for a model without a slow loop; on a board the firmware's own.",
    autocompletion=complete_estimators,
)
ESTIMATOR_OF_A_RECORDING = own_help(
    "--estimator",
    "Estimator by name: computes strain, displacement or force from voltages. Default: filter; polynomial (the "
    "paper's) for a model without a slow loop, and for a recording without a current.",
)
CONTROLLER = option(
    "--controller",
    help="Controller by name: computes the drive voltage. Default: that of --gains, else that of the gains in the "
    "model (inverse-model); fuzzy-pid for a model without gains; on a board the firmware's own.",
    autocompletion=complete_controllers,
)
TUNED_CONTROLLER = own_help("--controller", "Controller by name, whose gains are found.")
RULES = option(
    "--rules",
    help="Rule base of the fuzzy tuning; see 'musclewire rules'. Default: zhao-1993.",
    autocompletion=complete_rule_bases,
)
GAINS = option("--gains", help="Gains file from 'musclewire tune': controller and settings instead of the model's.")
APPROACH = quantity(
    "--approach",
    "s",
    "Time for which the first target is held before the first step, as '12 s'. Default: 0 s, and 12 s for a controller "
    "that cannot bring a cold wire there by itself.",
    0.0,
    3600.0,
)
CLOSED_LOOP_TIME = quantity(
    "--closed-loop-time", "s", "tau_c of the tuning rule; by default the dead time.", 1e-3, 86400.0
)
WIRE_FILE = option(
    "--wire-file",
    metavar="FILE",
    help="The wire's own file, from 'musclewire calibrate', for --estimator particle-filter: estimates by physics "
    "whatever load and air do.",
)
HOME = option(
    "--home", help="When to make a home move: start (before the run), idle (after it, while the wire cools) or never."
)
HOMED_MODEL = option("--homed-model", help="Model file to write after a home move (.json).")
CYCLES_MADE = option(
    "--cycles-made",
    help="Cycles that the wire has made since its characterization, if counted; kept in the model.",
    min=0,
    max=100_000_000,
)
SWEEP_FILE = option("--sweep", help="Recording of the home move's sweep to write (.h5).")
ZERO_FROM = option(
    "--zero-from",
    help="Where strain counts from: 'kept', the cold wire of the characterization, or 'today', this run's. From "
    "today's, resistance is scaled if the first heating turns elsewhere than the model's, and the room's air counts.",
    metavar="today|kept",
)
KNOWN_STRAIN = option(
    "--known-strain",
    help="A strain (displacement, force) that is known at a time of the run, or at the end of its first hold, as at an "
    "end stop: where the estimate misses it by more than its interval, the model is corrected for the rest of the run.",
    metavar="'1.2 % [at 12 s]'",
)
ON_BOARD = option(
    "--on-board", help="The board's firmware closes the loop; the host sends the targets and records the samples."
)
RUNS = option(
    "--runs",
    help="Run so many loops at once, each on a simulated rig with a seed of its own: from --seed, or 1, on.",
    min=1,
    max=MAX_COUNT,
)
IN_PYTHON = option("--in-python", help="With --runs: step every loop in Python, for what has no compiled form.")
OBJECT_STIFFNESS = quantity(
    "--object-stiffness", "N/m", "Stiffness of an object in the way of the endpoint, as '50 N/m'."
)
CLEARANCE = quantity(
    "--clearance", "m", "How far the endpoint moves (two fingers: both together) before it touches, as '4 mm'."
)

# Recordings and models.
COLUMN = option(
    "--column", "-c", help="Assign a header of the file to a column. Repeatable.", metavar="NAME=HEADER[:UNIT]"
)
LEG_LENGTH = quantity(
    "--leg-length", "m", "Length whose shortening is the strain, as '70 mm': one leg of a V-shaped wire."
)
SHUNT = quantity("--shunt", "ohm", "Shunt resistance of Eq. 1, as '1.0 ohm'.")
MAPPING = option(
    "--mapping", help="Mapping file from 'musclewire import --save-mapping' (.toml): how the file is read."
)
SAVE_MAPPING = option("--save-mapping", help="Mapping file to write (.toml), for the next file of this kind.")
SAMPLE_PERIOD = quantity(
    "--sample-period", "s", "Time between two rows of a file without a clock, as '10 ms'.", 1e-9, 86400.0
)
GROUP = option(
    "--group", "--sheet", help="Group, sheet or struct of a file that holds several tables (TDMS, HDF5, MATLAB, Excel)."
)
MATLAB_VERSION = option(
    "--matlab-version", help="Version of a .mat file to write: 5 or 7.3 (default: 5, unless it is too large)."
)
IGNORE = option("--ignore", help="Leave out a column, by its header or as #3. Repeatable.", metavar="COLUMN")
DROP_MISSING = option("--drop-missing", help="Leave out rows in which a used column has no number.")
TRUST_MAPPING = option("--trust-mapping", help="Let units of --column hold against others that the file states.")
JOIN = option(
    "--join",
    help="Join two files of loggers with different clocks by this column, or by one of each: FIRST=SECOND. "
    "By default by the only column that both have.",
    metavar="COLUMN",
)
DELAY = quantity(
    "--delay",
    "s",
    "Join two files, of which the second one's clock is ahead by this: what nothing in the files shows.",
    -1e9,
    1e9,
)
ZERO = option("--zero", help="Count displacement, strain and force from the first row.")
INVERT = option("--invert", help="The sensor reads backwards: negate displacement and strain.")
ORDER = option("--order", help="Order of the polynomials, or 'auto' (cross-validation).")
CYCLE = option("--cycle", help="Cycle that is fitted: first, last, largest, or a number from 0.")
RELATIVE_RESISTANCE = option(
    "--relative-resistance",
    help="Fit resistance over the cold wire's, with which recordings begin: for other wires of the kind, and no rig.",
)

# Wires, simulated and their own.
WIRE = option(
    "--wire",
    help="Wire by name ('musclewire simulate --list' shows all), or wire file (.toml).",
    autocompletion=complete_wires,
)
WIRE_LENGTH = quantity("--wire-length", "m", "Length of the wire between its terminals, both legs of a V together.")
LOAD = quantity(
    "--load",
    "N",
    "Your word that the load is that of the characterization: its weight, or the spring's pretension, as '1.4 N'. "
    "Without it, a change is refused that B and C do not separate from another load.",
)
AMBIENT = quantity(
    "--ambient",
    "K",
    "Temperature of the air in the home move, as '22 degC'; by default the rig's thermometer's.",
)
SET = option("--set", help="A number of the bench that no recording states. Repeatable.", metavar="NAME=VALUE")
THREADS = option("--threads", help="Threads; by default one on each core.", min=1, max=MAX_CORES)

# Studies of many wires.
WORKERS = option("--workers", help="Processes on this machine; by default one on each core.", min=1, max=MAX_CORES)

# Parts to design.
FILE = option("--file", help="Take all dimensions from a pretensioner's file.")

# Everything else.
ONLY = option("--only", help="Only rows whose names begin so: 'fig4', 'table2.mae'.", metavar="NAME")
QUICK = option("--quick", help="Fewer repetitions.")
SETTINGS = option("--settings", help="TOML file with settings of the controller, as kp_range = [0.01, 0.1].")
NAME = option("--name", help="Name of the library or FMU, a C identifier.")

Json = Annotated[bool, JSON]
BeyondCatalogue = Annotated[bool, BEYOND_CATALOGUE]
RigName = Annotated[
    str,
    typer.Argument(
        metavar="RIG",
        help="'simulated', 'finger', 'gripper', or the path of a TOML rig file. Templates to copy: 'arduino-uno', "
        "'serial-board', 'ni-pci-6229', 'ni-usb-6001'.",
        autocompletion=complete_rigs,
    ),
]


def as_option(advised: Argument) -> str:
    """Return an argument of Python as the option of the command line: load_n as --load, overwrite=True as --overwrite.

    The key of a bench's number goes to --set, and that of metadata is an option of its own.
    """
    name, value = advised
    if isinstance(value, Mapping):
        (inner,) = value.items()
        if name == "bench":
            return f"--set {inner[0]}={'VALUE' if inner[1] is None else shlex.quote(str(inner[1]))}"
        name, value = inner
    called = CALLED.get(name) or "--" + WITH_UNIT.sub("", name).replace("_", "-")
    if value is None or value is True:
        return called
    kind = OPTIONS[called].quantity if called in OPTIONS else None
    if kind is not None and isinstance(value, float):
        value = f"{value:g} {kind.unit}"
    return f"{called} {shlex.quote(str(value))}"


def mapping(pairs: list[str] | None, option: str = "--column") -> dict[str, str]:
    """Return repeated NAME=VALUE options as a mapping."""
    found: dict[str, str] = {}
    for pair in pairs or ():
        name, separator, value = pair.partition("=")
        if not (separator and name.strip() and value.strip()):
            raise CallerError(f"{option} {pair}: write {EXAMPLES[option]}")
        if found.get(name.strip(), value.strip()) != value.strip():
            both = f"'{found[name.strip()]}' and '{value.strip()}'"
            raise CallerError(f"{option} gives {name.strip()} twice, {both}: choose one")
        found[name.strip()] = value.strip()
    return found


@overload
def in_si(name: str, text: str) -> float: ...
@overload
def in_si(name: str, text: None) -> None: ...
@overload
def in_si(name: str, text: str | None) -> float | None: ...
def in_si(name: str, text: str | None) -> float | None:
    """Return an option such as '70 mm' in SI, None if not given. Raises CallerError if wrong or not allowed."""
    kind = OPTIONS[name].quantity
    if kind is None:
        raise KeyError(f"{name} is no quantity")
    if text is None:
        return None
    from musclewire.signals import parse_quantity

    try:
        value = parse_quantity(text, kind.unit)
    except CallerError as error:
        raise CallerError(f"{name}: {error}") from None
    if not kind.low <= value <= kind.high:
        if not kind.unit and kind.high == 1.0 and BARE.fullmatch(text) and 1.0 < value <= 100.0:
            raise CallerError(f"{name}: {text} is outside 0 to 1: for {text} % write '{text} %'")
        raise CallerError(f"{name}: {text} is outside {kind.low:g} to {kind.high:g} {kind.unit}")
    return value
