"""A setting of a rig file that its own load leaves without effect is refused, not ignored."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

PRETENSIONER = '[[load]]\npart = "pretensioner"\nstiffness = "386.2 N/m"\n'
WEIGHT = '[[load]]\npart = "weight"\nforce = "1.5 N"\n'


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ('[settings]\nspring_stiffness_n_per_m = "300 N/m"\n' + PRETENSIONER, "give a part 'spring' with a stiffness"),
        ('[settings]\npretension_n = "1 N"\n' + WEIGHT, "the part 'weight' is the pretension"),
    ],
)
def test_a_setting_that_the_load_leaves_without_effect_is_one_line(
    text: str, said: str, musclewire: Callable[..., Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("rig.toml").write_text(text, "utf-8")
    answer = musclewire("characterize", "rig.toml", "-o", "loop.h5")
    assert (answer.code, answer.out) == (2, "")
    assert len(answer.err.strip().splitlines()) == 1
    assert said in answer.err
    assert not Path("loop.h5").exists()


def test_a_pretension_beside_weight_and_spring_is_set(musclewire: Callable[..., Any], tmp_path: Path) -> None:
    rig = tmp_path / "rig.toml"
    rig.write_text('[settings]\npretension_n = "1 N"\n' + PRETENSIONER + WEIGHT, "utf-8")
    answer = musclewire("characterize", rig, "-o", tmp_path / "l.h5", "--cycles", "1", "--period", "20", "--json")
    assert answer.code == 0, answer.err
