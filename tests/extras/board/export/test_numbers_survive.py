"""Every number of a library reads back as the one Python has; what single precision cannot hold is refused by name."""

from __future__ import annotations

import math
import re
import struct
import subprocess
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from tests.extras.board.export.export_parts import Exported, export, limits_for, usual_model
from tests.tools import require_tool

from musclewire.controllers import DriveLimits, FuzzyPidSettings
from musclewire.errors import CallerError
from musclewire.extras.board import literal, write_library

# A double exactly half-way between two singles, whose shortest text lies to one side of it.
HALF_WAY = 1.0 + 2.0**-24


def nearest_single(text: str) -> float:
    """The single nearest to a decimal text, ties to even, by exact arithmetic and not by way of a double."""
    exact = Fraction(text)
    guess = np.float32(float(exact))
    near = [guess, np.nextafter(guess, np.float32(np.inf)), np.nextafter(guess, np.float32(-np.inf))]

    def distance(candidate: np.float32) -> tuple[Fraction, int]:
        bits = struct.unpack("<I", struct.pack("<f", float(candidate)))[0]
        return abs(Fraction(float(candidate)) - exact), bits & 1

    return float(min((one for one in near if math.isfinite(one)), key=distance))


@given(value=st.floats(-1e30, 1e30).filter(lambda v: v == 0.0 or abs(v) > 1e-30))
@example(value=1e-7)
@example(value=HALF_WAY)
@example(value=-HALF_WAY * 3.0)
def test_a_literal_reads_back_as_the_same_double_and_its_nearest_single(value: float) -> None:
    text = literal(value)
    assert float(text) == value
    assert nearest_single(text) == float(np.float32(value))
    assert re.fullmatch(r"-?[\d.]+(e[+-]?\d+)?", text)
    assert "." in text or "e" in text


@pytest.mark.parametrize("double", [True, False], ids=["double", "single"])
def test_the_compiler_reads_every_number_as_python_has_it(
    exported: Callable[[str], Exported], tmp_path: Path, double: bool
) -> None:
    gcc = require_tool("gcc", "gcc libc6-dev")
    one = exported("liu-7x7")
    lines = []
    for constant in one.library.constants.all():
        if constant.kind != "real":
            continue
        if constant.columns:
            lines.append(f"static const mw_real t_{constant.name}[][{constant.columns}] = MW_{constant.name};")
        elif constant.table:
            lines.append(f"static const mw_real t_{constant.name}[] = MW_{constant.name};")
        else:
            lines.append(f"static const mw_real t_{constant.name}[] = {{MW_{constant.name}}};")
    names = [constant.name for constant in one.library.constants.all() if constant.kind == "real"]
    prints = [
        f"for (i = 0; i < sizeof t_{name} / sizeof(mw_real); i++) "
        f'printf("%.17g\\n", (double)((const mw_real *)t_{name})[i]);'
        for name in names
    ]
    body = "\n".join([*lines, "int main(void) { unsigned i;", *prints, "return 0; }"])
    source = tmp_path / "numbers.c"
    source.write_text(f'#include <stdio.h>\n#include "mw_real.h"\n{body}\n', encoding="utf-8")
    precision = ["-DMW_DOUBLE"] if double else []
    program = tmp_path / "numbers"
    subprocess.run(
        [gcc, "-std=c99", *precision, f"-I{one.library.folder / 'src'}", str(source), "-o", str(program)], check=True
    )
    printed = subprocess.run([program], capture_output=True, text=True, check=True).stdout.split()
    wanted = [value for c in one.library.constants.all() if c.kind == "real" for value in c.values]
    rounded = [value if double else float(np.float32(value)) for value in wanted]
    assert [float(text) for text in printed] == rounded


def cancelling_model(power: int = 12, size: float = 2e4) -> dict[str, tuple[float, ...]]:
    """Two branches with huge terms that cancel in their mean, which falls as it should."""
    bump = np.zeros(power + 1)
    bump[[power - 1, power]] = size, -size
    fall = np.zeros(power + 1)
    fall[:2] = 0.04, -0.03
    return {
        "heating_coefficients": tuple((fall + bump).tolist()),
        "cooling_coefficients": tuple((fall - bump).tolist()),
    }


def test_coefficients_that_cancel_are_refused_by_name(tmp_path: Path) -> None:
    with pytest.raises(CallerError, match=r"heating_coefficients\[1[12]\], -?20000.0, is cancelled"):
        export(tmp_path / "library", model=usual_model(**cancelling_model()))
    assert not (tmp_path / "library").exists()
    export(tmp_path / "library", model=usual_model(**cancelling_model()), double=True)


@pytest.mark.parametrize(
    ("setting", "name"),
    [
        ({"kp_range": (1e-40, 0.1)}, r"kp_range\[0\]"),
        ({"input_scale": 1e-39}, "input_scale"),
        ({"error_unit": 1e-37, "input_scale": 1e10}, "quantity's"),
    ],
)
def test_a_setting_that_single_precision_cannot_hold_is_refused(
    tmp_path: Path, setting: dict[str, float], name: str
) -> None:
    with pytest.raises(CallerError, match=name):
        export(tmp_path / "library", settings=FuzzyPidSettings(**setting))
    assert not (tmp_path / "library").exists()


def test_voltages_that_become_one_number_are_refused(tmp_path: Path) -> None:
    limits = limits_for(usual_model())
    alike = limits._replace(sense_voltage_v=limits.maximum_voltage_v * (1.0 - 1e-9))
    with pytest.raises(CallerError, match=r"sense_voltage_v .* are one number"):
        export(tmp_path, limits=alike)


def test_drive_limits_other_than_the_protection_s_are_refused(tmp_path: Path) -> None:
    model, limits = usual_model(), limits_for(usual_model())
    with pytest.raises(CallerError, match="maximum_voltage_v is 9 V in the drive limits"):
        write_library(model, FuzzyPidSettings(), DriveLimits(limits.sense_voltage_v, 9.0), limits, tmp_path)


def test_a_limit_that_is_none_is_none_in_c(tmp_path: Path) -> None:
    one = export(tmp_path, limits=limits_for(usual_model(), maximum_current_a=math.inf))
    header = (one.library.folder / "src/mw_constants.h").read_text("utf-8")
    assert "#define MW_MAXIMUM_CURRENT_A MW_LARGEST" in header


def test_a_comment_cannot_end_early(tmp_path: Path) -> None:
    one = export(tmp_path, model=usual_model(source="loop */ #error\n\\"))
    first = (one.library.folder / "src/mw_constants.h").read_text("utf-8").split("#ifndef", 1)[0]
    assert first.count("*/") == first.count("/*")
    assert "#error" in first  # as a word of the comment
    assert "\\" not in first
