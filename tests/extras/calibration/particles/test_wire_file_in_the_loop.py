"""The particle filter by its name and a wire file, in control and estimate; what does not fit is said."""

from __future__ import annotations

from pathlib import Path

import pytest
from tests.command_line import CommandLine

import musclewire as mw
from musclewire.errors import CallerError
from musclewire.identify import users_wire


@pytest.fixture(scope="module")
def model_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("model") / "model.json"
    with mw.open_rig("simulated", seed=2) as rig:
        mw.fit(mw.characterize(rig, path=path.with_name("loop.h5"))).save(path)
    return path


@pytest.mark.slow
def test_control_takes_the_particle_filter_and_records_what_it_finds(
    wire_file: Path, model_file: Path, musclewire: CommandLine, tmp_path: Path
) -> None:
    run_file = tmp_path / "run.h5"
    steps = ("--reference", "1.5 % to 2.1 % by 0.3 %")
    answer = musclewire(
        *("control", "simulated", model_file, "--estimator", "particle-filter", "--wire-file", wire_file),
        *(*steps, "-o", run_file, "--json"),
    ).json
    assert answer["estimator"] == "particle-filter"
    assert answer["mae_max_approached_pct"] < 2.62  # the largest error of the paper
    assert answer["health"] == ""
    run = mw.read_recording(run_file)
    assert run.metadata["wire_file"] == "mine.toml"
    assert abs(run["load_change_n"][-1]) < 0.3
    report = mw.estimate(mw.load_model(model_file), run, estimator="particle-filter", wire_file=wire_file)
    assert report.rms_pct is not None
    assert report.rms_pct < 1.5


@pytest.mark.parametrize("estimator", ["polynomial", "filter", None])
def test_a_wire_file_that_the_estimator_does_not_read_is_refused_with_the_one_that_does(
    wire_file: Path, model_file: Path, musclewire: CommandLine, estimator: str | None
) -> None:
    named = () if estimator is None else ("--estimator", estimator)
    for command in (("control", "simulated", model_file), ("estimate", model_file, model_file.with_name("loop.h5"))):
        run = musclewire(*command, "--wire-file", wire_file, *named)
        assert run.code == 2
        assert "--estimator particle-filter" in run.err


def test_a_load_that_nobody_states_is_refused(wire_file: Path) -> None:
    with pytest.raises(CallerError, match="states spring_stiffness_n_per_m, pretension_n"):
        users_wire(wire_file, {"wire_length_m": 0.14})
    with pytest.raises(CallerError, match="is no wire file"):
        users_wire("paper-100um", {})
