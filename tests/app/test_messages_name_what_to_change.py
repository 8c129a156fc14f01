"""What a person typed and what the wire did is named in the answer: rigs, warnings, gaps."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from musclewire.files import read_recording


def test_a_blocked_wire_is_recorded_with_a_warning_and_the_word_that_there_is_no_loop(
    musclewire: Callable[..., Any], tmp_path: Any
) -> None:
    rig = tmp_path / "held.toml"
    rig.write_text('[[load]]\npart = "blocked"\n', "utf-8")
    call = ("characterize", rig, "-o", tmp_path / "held.h5", "--cycles", "1", "--period", "30 s")
    answer = musclewire(*call)
    assert answer.code == 1
    assert "no loop: the part 'blocked' holds the wire" in answer.out
    pull_n = read_recording(tmp_path / "held.h5")["force_n"].max()
    assert f"warning: the wire pulls with up to {pull_n:.2f} N" in answer.err
    document = musclewire(*call, "--overwrite", "--json").json
    assert [text for text in document["warnings"] if "allowed (maximum_force_n" in text] == document["warnings"][:1]
    assert document["strain_gap_pct"] is document["stroke_pct"] is None
    refused = musclewire("fit", tmp_path / "held.h5", "--quantity", "force")
    assert refused.code == 2
    assert "there is nothing to fit" in refused.err


def test_characterize_shows_every_gap_and_that_of_a_fingers_endpoint(
    musclewire: Callable[..., Any], tmp_path: Any
) -> None:
    short = ("--cycles", "1", "--period", "40 s")
    finger = musclewire("characterize", "finger", "-o", tmp_path / "finger.h5", *short).out
    assert all(f"{name} gap" in finger for name in ("strain", "displacement", "force"))
    spring = musclewire("characterize", "simulated", "-o", tmp_path / "spring.h5", *short).out
    assert "strain gap" in spring
    assert "displacement gap" not in spring


def test_a_sweep_warns_on_stderr_and_in_json(musclewire: Callable[..., Any], tmp_path: Any) -> None:
    rig = tmp_path / "stiff.toml"
    rig.write_text('[[load]]\npart = "spring"\nstiffness = "2000 N/m"\n', "utf-8")
    answer = musclewire(
        "pretension", rig, "--at", "0.5 N", "--at", "3 N", "--cycles", "1", "--period", "60 s", "--json"
    )
    assert (answer.code, answer.json["best_pretension_n"]) == (1, None)
    assert answer.json["advice"].startswith("no pretension of these is within the wire's limit")
    (warning,) = [text for text in answer.json["warnings"] if "allowed (maximum_force_n" in text]
    assert warning.startswith("pretension 3 N: the wire pulls with up to ")
    assert f"warning: {warning}" in answer.err


def test_a_staircase_is_answered_in_the_unit_in_which_it_was_asked_for(
    musclewire: Callable[..., Any], model: Any
) -> None:
    def refusal(reference: str) -> str:
        return str(musclewire("control", "simulated", model, "--reference", reference).refusal)

    assert "the reference goes from 0.5 to 6 %, but this model senses strain only from" in refusal(
        "0.5 % to 6 % by 0.6 %"
    )
    assert refusal("1 % to 3 % by 0.6 %").endswith("from 1 % to 3 %: increments of 0.6 % miss the stop; try 0.666667 %")
