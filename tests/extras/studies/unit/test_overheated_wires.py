"""A study says which wires went beyond the highest temperature that their protection allows."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from tests.command_line import CommandLine
from tests.extras.studies.unit.study_parts import study_of

import musclewire as mw
from musclewire.extras.studies import Workers, read_study_data, sweep
from musclewire.small_files import toml_text

HERE = Workers(processes=1)


def study(**run: Any) -> dict[str, Any]:
    known = {"kind": "characterize", "cycles": 1, "period": "20 s", "keep": ["stroke", "temperature_max_k"]}
    return study_of(run={**known, **run}, parameters={"wire_length": {"values": ["60 mm", "140 mm"]}})


def test_wires_that_are_driven_by_their_own_amplitude_stay_within() -> None:
    result = sweep(study(), workers=HERE)
    assert result.overheated == ()
    assert (result.columns["temperature_max_k"] <= 413.15).all()


def test_a_voltage_for_all_lengths_burns_the_short_one_and_is_told() -> None:
    with_limit = {**study(amplitude="3.2 V"), "rig": {"maximum_voltage": "3.6 V"}}
    result = sweep(with_limit, workers=HERE)
    (found,) = result.overheated
    assert found.run == 0
    assert found.limit_k == pytest.approx(473.15)
    assert found.temperature_max_k == result.columns["temperature_max_k"][0] > found.limit_k


def test_on_a_rig_the_protections_own_estimate_tells() -> None:
    tripped = {**study(amplitude="3.2 V", readings="rig", keep=["stroke"]), "rig": {"maximum_voltage": "3.6 V"}}
    result = sweep(tripped, workers=HERE)
    assert [one.run for one in result.overheated] == [0]
    # It tripped before the sample that would have ended above the limit.
    assert result.overheated[0].temperature_max_k == pytest.approx(result.overheated[0].limit_k, abs=5.0)
    assert result.failed == 1


@pytest.mark.slow
def test_the_command_ends_with_1_and_the_folder_keeps_it(tmp_path: Path, musclewire: CommandLine) -> None:
    file = tmp_path / "lengths.toml"
    file.write_text(toml_text({**study(amplitude="3.2 V"), "rig": {"maximum_voltage": "3.6 V"}}), "utf-8")
    folder = tmp_path / "out"
    for _ in range(2):  # the second time from what the folder has
        done = musclewire("sweep", file, "-o", folder, "--workers", "1", "--json")
        assert done.code == 1
        (found,) = done.json["overheated"]
        assert (found["run"], found["limit_k"]) == (0, pytest.approx(473.15))
    assert json.loads(read_study_data(folder).attrs["overheated"]) == [found]
    assert mw.read_study_data(folder)["stroke"].size == 2
    said = musclewire("sweep", file, "-o", folder, "--workers", "1")
    assert "1 wires went beyond their limit of temperature: runs 0" in said.out + said.err
