"""The firmware's parts, compiled by the host's compiler with its sanitizers, and its frames against Python's."""

from __future__ import annotations

import random
import re
import subprocess
from pathlib import Path

import pytest
from firmware.build import FIRMWARE, write_sources
from tests.tools import require_tool

from musclewire.extras.board import FrameParser, SerialFrame, encode_frame

TESTS = Path(__file__).with_name("host_tests.c")
HEADER = FIRMWARE.parent / "src/musclewire/extras/board/c_library/mw_protect.h"
STRUCTURE = re.compile(r"typedef struct \{(.*?)\} mw_protection;", re.S)
SANITIZED = ["-fsanitize=address,undefined", "-fno-sanitize-recover=all"]


def compiled(folder: Path, *options: str) -> Path:
    """Compile the tests with the firmware's parts; warnings are errors."""
    compiler = require_tool("gcc", "gcc libc6-dev")
    write_sources("mps2-an386", folder)
    sources = [file for file in sorted((FIRMWARE / "src").glob("*.c")) if file.name != "main.c"]
    sources += sorted((folder / "src").glob("*.c"))
    program = folder / "host_tests"
    strict = ["-std=gnu99", "-O1", "-ffp-contract=off", "-Wall", "-Wextra", "-Werror", "-Wno-unknown-pragmas"]
    places = [f"-I{FIRMWARE / 'src'}", f"-I{folder / 'src'}"]
    command = [
        compiler,
        *strict,
        *SANITIZED,
        *options,
        *places,
        str(TESTS),
        *map(str, sources),
        "-lm",
        "-o",
        str(program),
    ]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return program


@pytest.fixture(scope="module")
def program(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return compiled(tmp_path_factory.mktemp("firmware"))


def test_every_part_does_what_its_test_says(program: Path) -> None:
    done = subprocess.run([str(program)], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr


def test_stand_alone_the_button_starts_and_a_watchdog_reset_does_not(tmp_path: Path) -> None:
    done = subprocess.run([str(compiled(tmp_path, "-DMW_STANDALONE"))], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr


def test_frames_are_the_same_in_c_and_in_python(program: Path) -> None:
    drawn = random.Random(5)
    frames = [
        SerialFrame(drawn.randrange(256), drawn.randrange(65536), drawn.randbytes(drawn.randrange(89)))
        for _ in range(500)
    ]
    frames += [SerialFrame(0, 0, b""), SerialFrame(255, 65535, b"\0" * 88), SerialFrame(3, 1, b"\x01" * 88)]
    lines = "".join(f"{frame.kind} {frame.sequence} {frame.payload.hex() or '-'}\n" for frame in frames)
    said = subprocess.run(
        [str(program), "frames"], input=lines, capture_output=True, text=True, check=True
    ).stdout.split()
    assert said == [encode_frame(frame).hex() for frame in frames]
    assert FrameParser().feed(bytes.fromhex("".join(said))) == frames


def test_no_program_writes_into_the_protection_but_the_library() -> None:
    fields = re.findall(r"^    (?:uint\w+|mw_real) ([\w, ]+)", STRUCTURE.search(HEADER.read_text("utf-8"))[1], re.M)
    names = {name.strip() for group in fields for name in group.split(",")}
    assert {"state", "event", "missing_us", "above_ambient_k"} <= names
    writes = re.compile(rf"protection(?:\.|->)(?:{'|'.join(sorted(names))})(?:\[.*?\])?\s*[-+*/|&]?=[^=]")
    for file in (*sorted((FIRMWARE / "src").glob("*.c")), *sorted((FIRMWARE / "boards").rglob("*.c"))):
        assert not writes.findall(file.read_text("utf-8")), file.name
