"""The exported Arduino sketch does what its comment promises, run on this machine with pins and clock of the test."""

from __future__ import annotations

import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest
from tests.extras.board.export.export_parts import Exported
from tests.tools import require_tool

from musclewire.controllers import Event, State

STAND_IN = Path(__file__).with_name("arduino_stand_in.h")
# A wire of 16 ohm on a shunt of 1 ohm, seen through the sketch's own numbers; what is typed; for how long.
MAIN = """
int main(int, char **arguments) {
  setup();
  if (drive_counts != 0) return 2;
  typed = arguments[1];
  for (int tick = 0; tick < 1000 * atof(arguments[2]); tick++) {
    clock_us += 1000;
    const float out_v = drive_counts * DRIVE_V_PER_COUNT, shunt_v = out_v / 17.0f;
    analogue_counts[0] = static_cast<int>(out_v / SUPPLY_V_PER_COUNT + 0.5f);
    analogue_counts[1] = static_cast<int>(shunt_v / SHUNT_V_PER_COUNT + 0.5f);
    loop();
  }
  printf("%d %d %d\\n", controller.protection.state, controller.protection.event, drive_counts);
}
"""


@pytest.fixture(scope="module")
def sketch(exported: Callable[[str], Exported], tmp_path_factory: pytest.TempPathFactory) -> Path:
    compiler, folder = require_tool("g++", "g++ libc6-dev"), exported("zhao-1993").library.folder
    out = tmp_path_factory.mktemp("sketch")
    text = (folder / "examples/wire/wire.ino").read_text("utf-8")
    (out / "sketch.cpp").write_text(f'#include "{STAND_IN}"\n{text}{MAIN}', "utf-8")
    objects = []
    for source in sorted((folder / "src").glob("*.c")):
        objects.append(str(out / f"{source.stem}.o"))
        subprocess.run(["gcc", "-std=c99", "-c", str(source), "-o", objects[-1]], check=True)
    strict = ["-std=c++11", "-Wall", "-Wextra", "-Werror", "-fsanitize=undefined", "-fno-sanitize-recover=all"]
    command = [compiler, *strict, f"-I{folder / 'src'}", str(out / "sketch.cpp"), *objects, "-o", str(out / "sketch")]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return out / "sketch"


def after(sketch: Path, typed: str, time_s: float) -> tuple[State, Event, int]:
    said = subprocess.run([str(sketch), typed, str(time_s)], capture_output=True, text=True, check=True).stdout.split()
    return State(int(said[0])), Event(int(said[1])), int(said[2])


def test_a_target_in_the_range_is_followed(sketch: Path) -> None:
    state, event, counts = after(sketch, "0.02\n", 1.0)
    assert (state, event) == (State.RUN, Event.NONE)
    assert counts > 0


@pytest.mark.parametrize("typed", ["12\n", "1e30\n", "inf\n", "nan\n", "stop\n", "\n", "0.02 0.03\n", "0" * 20])
def test_whatever_is_no_target_of_this_wire_switches_off(sketch: Path, typed: str) -> None:
    assert after(sketch, typed, 0.2) == (State.TRIPPED, Event.STOPPED, 0)


def test_a_silence_switches_off(sketch: Path) -> None:
    assert after(sketch, "0.02\n", 4.9)[0] is State.RUN
    assert after(sketch, "0.02\n", 5.2) == (State.TRIPPED, Event.COMMAND_MISSING, 0)
