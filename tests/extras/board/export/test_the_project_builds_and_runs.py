"""What is exported builds and runs as it stands: CMake, Arduino, C++, emulated processors, sanitizers."""

from __future__ import annotations

import shlex
import subprocess
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from emulation.exported_library.cost import emulated, linked, target_figures
from emulation.exported_library.on_this_machine import host_hash
from emulation.exported_library.targets import TARGETS
from tests.command_line import CommandLine
from tests.extras.board.export.export_parts import RULE_BASES, Exported, usual_model, whole_model
from tests.tools import require_tool

from musclewire.sensing import SensingModel, save_model

Libraries = Callable[[str], Exported]
CORTEX_M = [target for target in TARGETS if target.emulator != "simavr"]
SAMPLES = 5000
ARDUINO = Path("/usr/share/arduino/hardware/arduino/avr")
UNO = ["-mmcu=atmega328p", "-DF_CPU=16000000L", "-DARDUINO=10819", "-DARDUINO_AVR_UNO", "-DARDUINO_ARCH_AVR", "-Os"]


def run(*command: object, cwd: Path | None = None) -> str:
    done = subprocess.run([str(part) for part in command], cwd=cwd, capture_output=True, text=True, check=False)
    assert done.returncode == 0, f"{command[0]}\n{done.stdout}\n{done.stderr}"
    return done.stdout + done.stderr


def each_precision(single: Any, double: Any) -> list[pytest.ParameterSet]:
    """Return every library in a precision, the filter's in the other one; the rest is in the group slow.

    Golden vectors and bits of each in both are those of the libraries compiled in test_c_equals_python.py and beside.
    """
    quick, slow = {"zhao-1993": single, "filter": double, "inverse-model": single}, pytest.mark.slow
    return [
        pytest.param(made, precision, marks=() if precision == quick[made] else slow, id=f"{made}-{word}")
        for made in quick
        for word, precision in (("single", single), ("double", double))
    ]


def sources(one: Exported) -> list[Path]:
    return sorted((one.library.folder / "src").glob("*.c"))


@pytest.mark.parametrize(("made", "double"), each_precision("OFF", "ON"))
def test_the_cmake_project_builds_and_its_golden_vectors_hold(
    exported: Libraries, tmp_path: Path, made: str, double: str
) -> None:
    require_tool("cmake", "cmake make")
    require_tool("gcc", "gcc libc6-dev")
    folder = exported(made).library.folder
    run("cmake", "-S", folder, "-B", tmp_path, f"-DMW_DOUBLE={double}")
    assert "warning" not in run("cmake", "--build", tmp_path)
    assert "100% tests passed" in run("ctest", "--test-dir", tmp_path, "--output-on-failure")


@pytest.mark.parametrize(
    "rule_base",
    [
        *(RULE_BASES[0], "filter", "inverse-model"),
        *(pytest.param(name, marks=pytest.mark.slow) for name in RULE_BASES[1:]),
    ],
)
def test_golden_vectors_and_a_long_run_under_sanitizers(exported: Libraries, tmp_path: Path, rule_base: str) -> None:
    gcc = require_tool("gcc", "gcc libc6-dev")
    one = exported(rule_base)
    folder = one.library.folder
    watched = ["-fsanitize=address,undefined,float-cast-overflow", "-fno-sanitize-recover=all"]
    flags = [
        "-std=c99",
        "-pedantic",
        "-Wall",
        "-Wextra",
        "-Wconversion",
        "-Werror",
        "-O1",
        "-ffp-contract=off",
        *watched,
    ]
    for main, argument in (("golden_test", folder / "test/golden_vectors.csv"), ("same_bits", "20000")):
        program = tmp_path / main
        run(gcc, *flags, f"-I{folder / 'src'}", *sources(one), folder / f"test/{main}.c", "-o", program)
        run(program, argument)


@pytest.mark.slow
@pytest.mark.parametrize("double", [False, True], ids=["single", "double"])
@pytest.mark.parametrize(
    "flags",
    [
        pytest.param(["gcc", "-O0"], id="gcc -O0", marks=pytest.mark.slow),
        pytest.param(["gcc", "-O3", "-march=native"], id="gcc -O3 -march=native"),
        pytest.param(["clang", "-O2"], id="clang -O2"),
    ],
)
def test_no_compiler_and_no_optimisation_changes_a_bit(
    exported: Libraries, tmp_path: Path, flags: list[str], double: bool
) -> None:
    compiler = require_tool(flags[0], f"{flags[0]} libc6-dev")
    one = exported("zhao-1993")
    precision = ["-DMW_DOUBLE"] if double else []
    program = tmp_path / "same_bits"
    # gnu99 would let gcc fuse products and sums: the sources forbid it by themselves.
    command = [compiler, *flags[1:], "-std=gnu99", *precision, f"-I{one.library.folder / 'src'}", *sources(one)]
    main = one.library.folder / "test/same_bits.c"
    run(*command, "-ffp-contract=off", main, "-o", program)
    assert run(program, SAMPLES).strip() == host_hash(one.library.folder, SAMPLES, double=double)


@pytest.mark.parametrize(
    ("target", "made", "double"),
    [
        pytest.param(
            target,
            *one.values,
            marks=one.marks if target.name == "cortex-m4f" else pytest.mark.emulated,
            id=f"{target.name}-{one.id}",
        )
        for target in CORTEX_M
        for one in each_precision(False, True)
    ],
)
def test_an_emulated_processor_gives_the_bits_of_this_machine(
    exported: Libraries, tmp_path: Path, target: object, made: str, double: bool
) -> None:
    require_tool(target.compiler, target.packages)  # type: ignore[attr-defined]
    require_tool(target.emulator, target.emulator_packages)  # type: ignore[attr-defined]
    folder = exported(made).library.folder
    definitions = [f"SAMPLES={SAMPLES}", *(["MW_DOUBLE"] if double else [])]
    program = linked(folder, target, "test/same_bits.c", tmp_path, *definitions)  # type: ignore[arg-type]
    said = emulated(program, target).strip()  # type: ignore[arg-type]
    assert said == host_hash(folder, SAMPLES, double=double)
    assert f"{SAMPLES} samples" in said


def test_a_whole_tick_is_within_2000_instructions_and_8_kib_on_a_cortex_m4f(exported: Libraries) -> None:
    target = next(target for target in TARGETS if target.name == "cortex-m4f")
    require_tool(target.compiler, target.packages)
    require_tool(target.emulator, target.emulator_packages)
    row = target_figures(exported("zhao-1993").library.folder, target)
    assert row["tick_instructions_most"] <= 2000
    assert row["flash_bytes"] <= 8192
    assert row["ram_bytes"] == 0
    assert row == target_figures(exported("zhao-1993").library.folder, target)


def test_filter_and_inverse_model_are_within_15000_instructions_and_12_kib_on_a_cortex_m4f(exported: Libraries) -> None:
    target = next(target for target in TARGETS if target.name == "cortex-m4f")
    require_tool(target.compiler, target.packages)
    require_tool(target.emulator, target.emulator_packages)
    row = target_figures(exported("inverse-model").library.folder, target)
    assert row["tick_instructions_most"] <= 15_000
    assert row["flash_bytes"] <= 12 * 1024
    assert row["ram_bytes"] == 0


def test_the_cycles_of_a_tick_on_an_uno_are_counted(exported: Libraries) -> None:
    target = next(target for target in TARGETS if target.name == "atmega328p")
    require_tool(target.compiler, target.packages)
    require_tool(target.emulator, target.emulator_packages)
    row = target_figures(exported("zhao-1993").library.folder, target)
    assert 10_000 < row["tick_cycles_most"] < 80_000  # 5 ms of an Uno's 16 MHz
    assert row["ram_bytes"] == 0


@pytest.mark.parametrize("flag", ["-ffast-math", "-mfpmath=387"])
def test_flags_that_change_results_are_refused(exported: Libraries, tmp_path: Path, flag: str) -> None:
    gcc = require_tool("gcc", "gcc libc6-dev")
    folder = exported("fixed").library.folder
    done = subprocess.run(
        [gcc, "-std=c99", flag, f"-I{folder / 'src'}", "-c", folder / "src/mw_pid.c", "-o", tmp_path / "pid.o"],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode
    assert "musclewire: " in done.stderr


@pytest.mark.parametrize("made", ["zhao-1993", "filter", "inverse-model"])
def test_it_needs_no_library_function_at_all(exported: Libraries, tmp_path: Path, made: str) -> None:
    gcc = require_tool("gcc", "gcc libc6-dev")
    one = exported(made)
    flags = ["-std=c99", "-O2", "-ffreestanding", "-fno-stack-protector", "-nostdlib", "-r"]
    run(gcc, *flags, f"-I{one.library.folder / 'src'}", *sources(one), "-o", tmp_path / "all.o")
    missing = run("nm", "--undefined-only", tmp_path / "all.o").split()
    # What a freestanding compiler may call for copying a structure; newlib, avr-libc and gcc all have them.
    assert set(missing) <= {"U", "memset", "memcpy", "_GLOBAL_OFFSET_TABLE_"}


def test_the_arduino_sketch_builds_for_an_uno_with_the_arduino_core(exported: Libraries, tmp_path: Path) -> None:
    gcc = require_tool("avr-gcc", "gcc-avr avr-libc arduino-core-avr")
    if not ARDUINO.is_dir():
        require_tool("arduino-core-avr", "arduino-core-avr")  # says that it is not run, or fails in CI
    folder = exported("zhao-1993").library.folder
    plain = [*UNO, f"-I{ARDUINO / 'cores/arduino'}", f"-I{ARDUINO / 'variants/standard'}", f"-I{folder / 'src'}"]
    cpp = ["-std=gnu++11", "-fno-exceptions", "-fno-threadsafe-statics"]
    objects = []
    for item in [*(ARDUINO / "cores/arduino").glob("*.c"), *(ARDUINO / "cores/arduino").glob("*.cpp")]:
        objects.append(tmp_path / f"core_{item.name}.o")
        language = cpp if item.suffix == ".cpp" else ["-std=gnu11"]
        # Debian's avr-gcc is older than its core, which wants a constant of C++17.
        run(
            "avr-g++" if item.suffix == ".cpp" else gcc,
            *plain,
            *language,
            "-w",
            "-DDECIMAL_DIG=9",
            "-c",
            item,
            "-o",
            objects[-1],
        )
    strict = ["-Wall", "-Wextra", "-Werror"]
    for item in sources(exported("zhao-1993")):
        objects.append(tmp_path / f"{item.name}.o")
        run(gcc, *plain, "-std=gnu11", *strict, "-c", item, "-o", objects[-1])
    sketch = folder / "examples/wire/wire.ino"
    objects.append(tmp_path / "sketch.o")
    run("avr-g++", *plain, *cpp, *strict, "-x", "c++", "-include", "Arduino.h", "-c", sketch, "-o", objects[-1])
    run(gcc, "-mmcu=atmega328p", "-Os", "-Wl,--gc-sections", *objects, "-lm", "-o", tmp_path / "sketch.elf")
    text, data, bss = (int(n) for n in run("avr-size", tmp_path / "sketch.elf").splitlines()[-1].split()[:3])
    assert text + data < 32256 - 512
    assert data + bss < 1024


@pytest.mark.slow
def test_the_command_writes_the_library_without_any_compiler(
    tmp_path: Path, musclewire: CommandLine, monkeypatch: pytest.MonkeyPatch
) -> None:
    model = whole_model()
    save_model(model, tmp_path / "model.json")
    monkeypatch.setenv("PATH", "")
    asked = ("export", "c", tmp_path / "model.json", "-o", tmp_path / "library", "--name", "elbow", "--json")
    answer = musclewire(*asked).json
    assert all((tmp_path / "library" / name).is_file() for name in answer["files"])
    assert (tmp_path / "library/examples/elbow/elbow.ino").is_file()
    assert "@" not in (tmp_path / "library/library.properties").read_text()
    assert answer["single_error_share"] < 1e-4


WITHOUT_GAINS = replace(usual_model(), no_gains="two arrays")
ANOTHER_WIRE = usual_model(wire={"wire": "flexinol-0.20-lt"})
# Whoever edited the gains has to hear of it, also where the fuzzy PID takes none.
EDITED = replace(usual_model(), gains={"controller": "feedforward", "settings": {"closed_loop_time_s": -1.0}})


@pytest.mark.parametrize(
    ("model", "arguments", "complaints"),
    [
        (whole_model(), "--name 'my wire'", ["C identifier"]),
        (whole_model(), "--rig ni-pci-6229", ["is no board"]),
        (whole_model(), "--rules zhao --controller fuzzy-pid", ["zhao-1993"]),
        (whole_model(), "--settings gains.toml", ["did you mean 'kp_range'"]),
        (whole_model(), "--arduino-zip a.tar", [".zip"]),
        (whole_model(), "--controller feedforward", ["controller 'feedforward' has no form in C"]),
        (whole_model(), "--rules fixed", ["leave out settings and rules of the fuzzy PID, or name it by --controller"]),
        (ANOTHER_WIRE, "", ["fit one for this wire"]),
        (EDITED, "", ["gains", "closed_loop_time_s"]),
        (
            WITHOUT_GAINS,
            "",
            [
                "has none (two arrays): find them in the wire's slow loop by",
                "'musclewire tune model.json LOOP -o model.json', or take the paper's --estimator polynomial",
            ],
        ),
    ],
)
def test_what_the_command_cannot_write_is_one_line_and_nothing_is_written(
    tmp_path: Path, musclewire: CommandLine, monkeypatch: pytest.MonkeyPatch,
    model: SensingModel, arguments: str, complaints: list[str],
) -> None:  # fmt: skip
    monkeypatch.chdir(tmp_path)
    save_model(model, "model.json")
    Path("gains.toml").write_text("kp_rang = [0.0, 0.1]\n")
    refused = musclewire("export", "c", "model.json", "-o", "library", *shlex.split(arguments)).refusal
    assert [text for text in complaints if text not in refused] == []
    assert not Path("library").exists()
