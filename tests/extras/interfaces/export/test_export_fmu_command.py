"""The command export fmu: what it writes and says, and what it refuses."""

from __future__ import annotations

import zipfile
from pathlib import Path

import pytest
from tests.command_line import CommandLine
from tests.extras.board.export.export_parts import usual_model, whole_model

from musclewire.sensing import save_model


def test_a_rig_gives_a_wire(tmp_path: Path, musclewire: CommandLine) -> None:
    answer = musclewire("export", "fmu", "finger", "-o", tmp_path / "new" / "folder", "--sources-only", "--json").json
    assert (answer["kind"], answer["fmi_version"], answer["platform"], answer["step_s"]) == ("wire", "2.0", None, 0.05)
    assert answer["inputs"] == ["drive_voltage_v", "ambient_temperature_k", "convection_ratio", "external_force_n"]
    assert Path(str(answer["file"])) == tmp_path / "new" / "folder" / "wire.fmu"


def test_a_model_gives_a_controller_with_the_settings_and_rules_asked_for(
    tmp_path: Path, musclewire: CommandLine
) -> None:
    save_model(usual_model(), tmp_path / "model.json")
    (tmp_path / "gains.toml").write_text("kp_range = [0.0, 0.05]\n")
    given = ["--settings", tmp_path / "gains.toml", "--rules", "fixed", "--name", "elbow", "--sources-only"]
    given += ["--estimator", "polynomial", "--controller", "fuzzy-pid"]
    answer = musclewire("export", "fmu", tmp_path / "model.json", "-o", tmp_path, *given, "--json").json
    assert answer["kind"] == "controller"
    assert answer["inputs"] == ["wire_voltage_v", "shunt_voltage_v", "target"]
    assert {"kp", "ki", "kd"} <= set(answer["outputs"])
    assert (tmp_path / "elbow.fmu").exists()


def test_by_default_it_is_the_filter_with_the_inverse_of_the_model(tmp_path: Path, musclewire: CommandLine) -> None:
    save_model(whole_model(), tmp_path / "model.json")
    answer = musclewire("export", "fmu", tmp_path / "model.json", "-o", tmp_path, "--sources-only", "--json").json
    assert {"steady_power_w", "pending_heat_j", "power_limited"} <= set(answer["outputs"])
    header = zipfile.ZipFile(tmp_path / "controller.fmu").read("sources/mw_constants.h").decode("utf-8")
    assert "#define MW_FILTER 1" in header


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        (("simulated", "--rules", "fixed"), "--rules belongs to a controller, and simulated is a rig"),
        (("serial-board",), "is not simulated: an FMU is a simulated wire"),
        (("simulated", "--name", "my wire"), "C identifier"),
        (("model.json", "--rig", "ni-pci-6229"), "is no board"),
        (("other.json",), "fit one for this wire"),
        (("model.json",), "needs the gains of its wire, and model.json has none: find them"),
        (
            ("model.json", "--rules", "fixed"),
            "leave out settings and rules of the fuzzy PID, or name it by --controller",
        ),
    ],
)
def test_wrong_use_is_one_line_and_nothing_is_written(
    tmp_path: Path,
    musclewire: CommandLine,
    monkeypatch: pytest.MonkeyPatch,
    arguments: tuple[str, ...],
    complaint: str,
) -> None:
    monkeypatch.chdir(tmp_path)
    save_model(usual_model(), tmp_path / "model.json")
    save_model(usual_model(wire={"wire": "flexinol-0.20-lt"}), tmp_path / "other.json")
    assert complaint in musclewire("export", "fmu", *arguments, "-o", "out", "--sources-only").refusal
    assert not (tmp_path / "out").exists()
