"""Every ``python`` and ``sh`` block of the pages runs, page by page, in the order it is read.

The folder in which it runs has nothing but the checkout's examples. Blocks marked ``console`` are for reading: setting
up a checkout, and what needs a board, a card or a second terminal. They stand on the pages of ``FOR_READING`` only.
``mermaid`` is a drawing. The front doors' pages begin in a checkout: ``test_front_doors.py`` follows them.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest
from tests.house.docs.front_doors import DOORS
from tests.places import CHECKOUT

import musclewire as mw

# Pages whose blocks another test runs, and holds to what the page says.
FOLLOWED = {page for door in DOORS.values() for page in door.pages} | {"docs/how-to/questions.md"}
PAGES = sorted([*CHECKOUT.glob("*.md"), *(CHECKOUT / "docs").rglob("*.md")])
FOR_READING = {
    "CONTRIBUTING.md",
    "README.md",
    "add_your_own.md",
    "drive_a_board.md",
    "drive_an_ni_card.md",
    "export_a_controller_or_a_wire.md",
    "run_a_study_of_many_wires.md",
    "run_in_real_time.md",
    "wire_the_circuit.md",
}
BLOCK = re.compile(r"^```(\w*)\n(.*?)^```$", re.M | re.S)


def blocks(page: Path) -> list[tuple[str, str]]:
    return BLOCK.findall(page.read_text("utf-8"))


def name_of(page: Path) -> str:
    return page.relative_to(CHECKOUT).as_posix()


# A quick page, whose blocks every run of the tests runs; and pages whose blocks take 20 s or more: that these are
# still commands is tried by test_commands_on_pages_parse.py, and what they do by the tests of the commands.
ALWAYS = "numerics.md"
LONG = {
    "calibrate_my_wire.md",
    "change_the_simulated_rig.md",
    "check_the_simulator_against_the_paper.md",
    "choose_supply_shunt_and_current.md",
    "compare_estimators.md",
    "control.md",
    "design_a_finger.md",
    "estimators.md",
    "export_a_controller_or_a_wire.md",
    "files.md",
    "fit_without_a_displacement_sensor.md",
    "from_a_stroke_to_a_moving_finger.md",
    "grip_without_a_sensor.md",
    "plot_what_you_recorded.md",
    "pretension_train_and_home.md",
    "read_my_recordings.md",
    "run_a_study_of_many_wires.md",
    "run_in_real_time.md",
    "tune_a_controller.md",
}


def group_of(page: Path) -> tuple[pytest.MarkDecorator, ...]:
    if page.name == ALWAYS:
        return ()
    return (pytest.mark.full if page.name in LONG else pytest.mark.documented,)


WITH_CODE = [
    page
    for page in PAGES
    if name_of(page) not in FOLLOWED and any(language in {"python", "sh"} for language, _ in blocks(page))
]


@pytest.mark.parametrize(
    "page",
    [pytest.param(page, marks=group_of(page)) for page in WITH_CODE],
    ids=name_of,
)
def test_every_block_of_the_page_runs(page: Path, tmp_path: Path) -> None:
    namespace = tmp_path / ".namespace.py"
    python = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    # Which fonts a machine has is no fault of a page.
    strict = "error,ignore:none of the fonts"
    environment = {**os.environ, "PATH": python, "MPLBACKEND": "Agg", "PYTHONWARNINGS": strict}
    (tmp_path / "examples").symlink_to(CHECKOUT / "examples")
    said, found = "", blocks(page)
    for (language, text), (following, _) in pairwise([*found, ("", "")]):
        if "python3 -m venv" in text:
            continue  # setting up is what CI does before any test runs; see the test below
        if language == "sh":
            command = ["sh", "-eu", "-c", text.replace(".venv/bin/", "")]
        elif language == "python":
            # Later blocks of a page may use the names of earlier ones; blocks in a row run as one.
            said += text + "\n"
            if following == language:
                continue
            namespace.write_text(said, encoding="utf-8")
            command = [sys.executable, str(namespace)]
        else:
            continue
        done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False)
        assert done.returncode == 0, f"{text}\n{done.stdout}\n{done.stderr}"


def test_the_readme_starts_with_the_two_commands() -> None:
    _, first = next(block for block in blocks(CHECKOUT / "README.md") if block[0] == "sh")
    install, test = first.strip().splitlines()
    assert install == "python3 -m venv .venv && .venv/bin/pip install . && .venv/bin/musclewire demo"
    pytest_command = ".venv/bin/python -m pytest -n auto --dist worksteal"
    assert test == f'.venv/bin/pip install ".[test]" ./packages/design && {pytest_command}'


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_every_block_has_a_language_that_a_test_knows(page: Path) -> None:
    allowed = {"python", "sh", "mermaid"} | ({"console"} if page.name in FOR_READING else set())
    assert {language for language, _ in blocks(page)} <= allowed


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_every_link_within_the_repository_leads_somewhere(page: Path) -> None:
    text = re.sub(r"```.*?```", "", page.read_text("utf-8"), flags=re.S)
    for target in re.findall(r"\]\(([^)#\s]+)[^)]*\)", text):
        if "://" not in target:
            assert (page.parent / target).exists(), target


def test_a_class_with_two_methods_gets_a_closed_loop_in_25_lines() -> None:
    page = CHECKOUT / "docs/how-to/bring_your_own_plant.md"
    (loop,) = (text for language, text in blocks(page) if language == "python" and "class Bench" in text)
    assert sum(bool(line.strip()) for line in loop.splitlines()) <= 25
    with mw.open_rig("simulated", seed=1) as rig:
        names: dict[str, Any] = {"model": mw.fit(mw.characterize(rig))}
    exec(loop, names)
    names["bench"].wire.close()
    assert names["estimate"].valid
    assert names["bench"].sample.displacement_m / 0.070 == pytest.approx(0.02, abs=0.0005)
