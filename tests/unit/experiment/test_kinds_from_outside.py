"""An estimator and a controller of another package run the loop after one registration, by call or manifest."""

from __future__ import annotations

import sys
import types
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from tests.other_estimators import DriftingEstimator

import musclewire as mw
from musclewire.controllers import CONTROLLERS, ControllerSetup, DriveLimits, staircase
from musclewire.experiment import ControlRun
from musclewire.manifest import Manifest, manifests
from musclewire.sensing import ESTIMATORS
from musclewire.signals import ControlStep, Drive, QuantityEstimate, Reason


class OnOff:
    """Two voltages, and which one is recorded."""

    columns = ("on",)

    def __init__(self, limits: DriveLimits) -> None:
        self.limits = limits

    def start(self, drive_voltage_v: float) -> Drive:
        return Drive(self.limits.clamp(drive_voltage_v))

    def step(self, state: Drive, target: float, estimate: QuantityEstimate, _dt_s: float) -> ControlStep:
        if estimate.reason is Reason.NO_CURRENT:
            return ControlStep(state, state, (0.0,))
        on = estimate.value < target
        command = Drive(self.limits.clamp(3.0) if on else self.limits.sense_voltage_v)
        return ControlStep(command, command, (float(on),))


def on_off(setup: ControllerSetup) -> OnOff:
    return OnOff(setup.limits)


@pytest.fixture
def registered(monkeypatch: pytest.MonkeyPatch) -> None:
    for registry in (ESTIMATORS, CONTROLLERS):
        monkeypatch.setattr(registry, "_registered", {})
    ESTIMATORS.register("drifting", DriftingEstimator)
    CONTROLLERS.register("on-off", on_off)


@pytest.fixture
def offered(monkeypatch: pytest.MonkeyPatch) -> None:
    """A package that offers both in its manifest and registers nothing."""
    module = types.ModuleType("another_package")
    module.on_off, module.drifting = on_off, DriftingEstimator  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, "another_package", module)
    another = Manifest(
        "another",
        controllers={"on-off": "another_package:on_off"},
        estimators={"drifting": "another_package:drifting"},
    )
    there = (*manifests(), another)
    monkeypatch.setattr("musclewire.manifest.manifests", lambda: there)


@pytest.fixture(scope="module")
def model(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("model") / "model.json"
    with mw.open_rig("simulated", seed=1) as rig:
        mw.fit(mw.characterize(rig)).save(path)
    return path


@pytest.mark.usefixtures("registered")
def test_after_one_call_each_they_close_the_loop_on_the_simulated_rig(model: Path) -> None:
    with mw.open_rig("simulated", seed=1) as rig:
        run = mw.control(
            rig,
            mw.load_model(model),
            staircase(hold_s=0.5),
            estimator="drifting",
            controller="on-off",
            approach_s=3.0,
        )
    assert (run.metadata["estimator"], run.metadata["controller"]) == ("drifting", "on-off")
    assert set(run["on"]) == {0.0, 1.0}
    assert run["offset"].max() > 0.0
    assert "proportional_gain" not in run
    assert run.metrics.valid_share > 0.5


@pytest.mark.usefixtures("offered")
def test_by_a_manifest_the_command_line_knows_them_without_a_call(
    model: Path, tmp_path: Path, musclewire: Callable[..., Any]
) -> None:
    (tmp_path / "targets.csv").write_text("time_s,target_strain\n0,0.02\n1,0.022\n2,0.02\n")
    run = tmp_path / "run.h5"
    arguments = ("--reference", tmp_path / "targets.csv", "--controller", "on-off", "--estimator", "drifting")
    answer = musclewire("control", "simulated", model, *arguments, "-o", run, "--json").json
    assert (answer["estimator"], answer["controller"]) == ("drifting", "on-off")
    assert musclewire("estimate", model, run, "--estimator", "drifting", "--json").json["valid_share"] > 0.5


@pytest.fixture(scope="module")
def by_plain_pid(model: Path) -> ControlRun:
    with mw.open_rig("simulated", seed=1) as rig:
        return mw.control(rig, mw.load_model(model), staircase(hold_s=2.0), controller="pid", approach_s=8.0)


def test_a_plain_pid_closes_the_loop_by_its_name(by_plain_pid: ControlRun) -> None:
    assert by_plain_pid.metadata["controller"] == "pid"
    assert by_plain_pid.metrics.mae_mean_approached_pct is not None
    assert by_plain_pid.metrics.mae_mean_approached_pct < 1.5


@pytest.mark.xfail(
    strict=True,
    reason="3.46 % in the largest step after the approach: near B the branches of this wire are further apart",
)
def test_every_step_of_a_plain_pid_is_within_3_percent(by_plain_pid: ControlRun) -> None:
    assert by_plain_pid.metrics.mae_max_approached_pct is not None
    assert by_plain_pid.metrics.mae_max_approached_pct < 3.0
