"""Options of the commands for boards and exported C."""

from __future__ import annotations

from musclewire.app import completion_of, option, own_help

SERIAL_PORT = option("--serial-port", help="The board's port: /dev/ttyACM0, /dev/ttyUSB0, COM3. Default: found.")
OLD_BOOTLOADER = option(
    "--old-bootloader", help="The board is a Nano of before 2018: its boot loader takes 57600 baud."
)
MOUNTED_WIRE = own_help("--wire", "Wire that is mounted, by name: a built firmware keeps its limits.")
ESTIMATOR_IN_C = own_help(
    "--estimator",
    "Estimator by name, of those with a form in C: filter, or the paper's polynomial.",
    autocompletion=completion_of("filter", "polynomial"),
)
CONTROLLER_IN_C = own_help(
    "--controller",
    "Controller by name, of those with a form in C: inverse-model, by the model's gains, or the paper's fuzzy-pid.",
    autocompletion=completion_of("inverse-model", "fuzzy-pid"),
)
DRY_RUN = option("--dry-run", help="Print the loader's command, and write nothing.")
DOUBLE = option("--double", help="Double precision instead of single.")
ARDUINO_ZIP = option("--arduino-zip", help="The library as one .zip, too, for 'Add .ZIP Library' of the Arduino IDE.")
CIRCUIT = option("--board", help="Board, by name (pico, esp32, ...), or a file of its circuit (TOML).")
