"""What an export writes besides C: it replaces nothing unasked, Arduino's library and its sketch."""

from __future__ import annotations

import re
import subprocess
import zipfile
from collections.abc import Callable
from pathlib import Path

import pytest
from tests.extras.board.export.export_parts import Exported, drive_limits, limits_for, usual_model, whole_model
from tests.tools import require_tool

from musclewire.app import run
from musclewire.controllers import Event, FuzzyPidSettings, State
from musclewire.errors import CallerError
from musclewire.extras.board import CLibrary, write_library
from musclewire.sensing import save_model

# A folder that holds another library is left alone, whole; writing the very same again is no replacing.

LIMITS = limits_for(usual_model())


def write(folder: Path, *, overwrite: bool = False, **settings: tuple[float, float]) -> CLibrary:
    chosen = FuzzyPidSettings(**settings)
    return write_library(usual_model(), chosen, drive_limits(LIMITS), LIMITS, folder, "wire", overwrite=overwrite)


def contents(library: CLibrary) -> dict[str, bytes]:
    return {name: (library.folder / name).read_bytes() for name in library.files}


def test_the_same_library_may_be_written_again(tmp_path: Path) -> None:
    first = contents(write(tmp_path))
    assert contents(write(tmp_path)) == first


def test_another_library_is_refused_and_nothing_is_changed(tmp_path: Path) -> None:
    library = write(tmp_path)
    before = contents(library)
    with pytest.raises(CallerError, match=r"holds another src/mw_constants\.h.*overwrite=True"):
        write(tmp_path, kp_range=(0.01, 0.09))
    assert contents(library) == before


def test_a_file_that_was_edited_by_hand_is_kept(tmp_path: Path) -> None:
    library = write(tmp_path)
    name = library.files[0]
    (tmp_path / name).write_text("mine", "utf-8")
    with pytest.raises(CallerError, match="holds another"):
        write(tmp_path)
    assert (tmp_path / name).read_text("utf-8") == "mine"


def test_it_is_replaced_where_that_is_asked_for(tmp_path: Path) -> None:
    before = contents(write(tmp_path))
    assert contents(write(tmp_path, overwrite=True, kp_range=(0.01, 0.09))) != before


# The .zip of an exported library keeps to Arduino's written library specification (format 1.5).

FIELDS = ("name", "version", "author", "maintainer", "sentence", "paragraph", "category", "url", "architectures")
CATEGORIES = (
    "Display", "Communication", "Signal Input/Output", "Sensors", "Device Control", "Timing", "Data Storage",
    "Data Processing", "Other",
)  # fmt: skip
NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9 _.-]{0,62}")
SEMANTIC = re.compile(r"\d+\.\d+(\.\d+)?([-+][0-9A-Za-z.-]+)?")


@pytest.fixture(scope="module")
def archive(tmp_path_factory: pytest.TempPathFactory) -> zipfile.ZipFile:
    """Return the .zip that the command writes."""
    folder = tmp_path_factory.mktemp("arduino")
    save_model(whole_model(), folder / "model.json")
    asked = ["export", "c", folder / "model.json", "-o", folder / "library", "--name", "elbow"]
    assert run([str(one) for one in (*asked, "--arduino-zip", folder / "elbow.zip")]) == 0
    return zipfile.ZipFile(folder / "elbow.zip")


def properties(archive: zipfile.ZipFile) -> dict[str, str]:
    lines = archive.read("elbow/library.properties").decode("utf-8").splitlines()
    return dict(line.split("=", 1) for line in lines)


def test_one_folder_holds_all_of_it(archive: zipfile.ZipFile) -> None:
    names = archive.namelist()
    assert {name.split("/")[0] for name in names} == {"elbow"}
    assert {"elbow/library.properties", "elbow/keywords.txt", "elbow/LICENSE"} <= set(names)
    assert not [name for name in names if name.endswith((".exe", ".o", ".a")) or "/." in name]


def test_its_properties_are_those_of_the_specification(archive: zipfile.ZipFile) -> None:
    found = properties(archive)
    assert set(FIELDS) <= set(found)
    assert NAME.fullmatch(found["name"])
    assert not found["name"].lower().startswith("arduino")
    assert SEMANTIC.fullmatch(found["version"])
    assert found["category"] in CATEGORIES
    assert all(found[field] for field in FIELDS if field != "url")
    assert not found["paragraph"].startswith(found["sentence"])
    assert all(f"elbow/src/{header.strip()}" in archive.namelist() for header in found["includes"].split(","))


def test_a_sketch_has_the_name_of_its_folder_and_includes_the_library(archive: zipfile.ZipFile) -> None:
    sketches = [name for name in archive.namelist() if name.startswith("elbow/examples/") and name.endswith(".ino")]
    assert [Path(name).stem for name in sketches] == [Path(name).parent.name for name in sketches] == ["elbow"]
    assert "#include <musclewire.h>" in archive.read(sketches[0]).decode("utf-8")


def test_keywords_are_names_of_the_header_with_a_tab(archive: zipfile.ZipFile) -> None:
    header = archive.read("elbow/src/musclewire.h").decode("utf-8")
    rows = [line.split("\t") for line in archive.read("elbow/keywords.txt").decode("utf-8").splitlines()]
    assert all(len(row) == 2 and row[0] in header and row[1] in {"KEYWORD1", "KEYWORD2"} for row in rows)
    assert {"mw_controller", "mw_start", "mw_tick"} <= {row[0] for row in rows}


# The exported Arduino sketch does what its comment promises, run on this machine with pins and clock of the test.

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
