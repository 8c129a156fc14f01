"""A study's file: what is refused, and what a resumed study is recognised by."""

from __future__ import annotations

from typing import Any

import pytest
from tests.extras.studies.unit.study_parts import study_of

from musclewire.errors import CallerError
from musclewire.extras.studies import read_study


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"parameters": {"pretention_n": {"values": [1.9]}}}, "'pretention_n'; did you mean 'pretension_n'"),
        ({"parameters": {"pretension": {"values": [1.9]}, "pretension_n": {"values": [1.9]}}}, "are the same number"),
        ({"run": {"kind": "characterize", "period": "20 m"}}, "time is needed|seconds"),
        ({"run": {"kind": "math:pi"}}, "is a float, not a RunKind"),
        ({"sampling": {"samples": 3}, "parameters": {"pretension": {"low": 1.0, "high": 2.0}}}, "power of 2, 2 or 4"),
    ],
)  # fmt: skip
def test_a_wrong_key_or_name_is_one_line_with_the_nearest_right_one(changes: dict[str, Any], words: str) -> None:
    with pytest.raises(CallerError, match=words):
        read_study(study_of(**changes))


def test_a_spring_that_parts_replace_has_no_effect_and_is_refused() -> None:
    rig = {"load": [{"part": "spring", "stiffness": "500 N/m"}]}
    with pytest.raises(CallerError, match=r"vary load\.spring\.stiffness"):
        read_study(study_of(rig=rig, parameters={"spring_stiffness_n_per_m": {"values": [500.0]}}))


def test_tables_may_be_nested_as_toml_nests_them() -> None:
    rig = {"load": [{"part": "spring", "stiffness": "500 N/m"}]}
    nested = {
        "load": {"spring": {"stiffness": {"values": ["400 N/m", "600 N/m"]}}},
        "run": {"amplitude": {"values": [3.0]}},
    }
    plan = read_study(study_of(rig=rig, parameters=nested))
    assert plan.design.names == ("load.spring.stiffness", "run.amplitude")
    assert plan.design.units["load.spring.stiffness"] == "N/m"
    assert plan.design.units["run.amplitude"] == "V"


def test_the_fingerprint_is_the_same_for_the_same_study_and_another_for_any_change() -> None:
    def fingerprint(**changes: Any) -> str:
        return read_study(study_of(**changes)).fingerprint

    others = [
        fingerprint(seed=2),
        fingerprint(parameters={"pretension": {"values": ["1.5 N", "1.8 N"]}}),
        fingerprint(rig="finger"),
        fingerprint(run={"kind": "characterize", "cycles": 2, "period": "20 s", "keep": ["stroke"]}),
    ]
    assert fingerprint() == fingerprint()
    assert len({fingerprint(), *others}) == 5
