"""Two simulated fingers and a block of foam, in a room with draughts; every run with a seed of its own."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import musclewire as mw
from musclewire.errors import CallerError, RecordingError
from musclewire.extras.grip import GripperKnowledge, close_fingers, grip, load_knowledge, train_gripper, with_object
from musclewire.parameters import load_finger
from musclewire.rigs import open_rig, rig_configuration
from musclewire.signals import Recording
from musclewire.wire import ElasticObject


def gripped(
    knowledge: GripperKnowledge,
    block: ElasticObject | None,
    seed: int,
    stiffness: float | None = None,
    target_n: float = 0.3,
) -> Any:
    with open_rig(with_object("gripper", block), seed=seed) as rig:
        return grip(rig, knowledge, target_n=target_n, stiffness_n_per_m=stiffness)


@pytest.mark.slow
def test_twenty_free_closings_in_draughts_raise_no_alarm(knowledge: GripperKnowledge) -> None:
    runs = [gripped(knowledge, None, seed) for seed in range(20)]
    assert [run.contact_s for run in runs] == [None] * 20
    # Without contact the fingers open again and the wires are left at the sense voltage.
    assert all(run["drive_voltage_v"][-1] == pytest.approx(0.3, abs=1e-3) for run in runs)


@pytest.mark.slow
@pytest.mark.parametrize("stiffness", [50.0, 200.0, 1000.0])
@pytest.mark.parametrize("clearance_m", [4e-3, 7e-3, 9e-3])
def test_contact_is_found_before_the_true_force_exceeds_0_15_n(
    knowledge: GripperKnowledge, stiffness: float, clearance_m: float
) -> None:
    for seed in range(3):
        run = gripped(knowledge, ElasticObject(stiffness, clearance_m), seed)
        assert run.true_force_at_contact_n is not None
        assert run.true_force_at_contact_n < 0.15
        assert run.opening_m == pytest.approx(clearance_m, abs=0.5e-3)


@pytest.mark.parametrize("seed", range(4))
def test_with_known_stiffness_the_held_force_is_estimated_within_a_tenth_of_a_newton(
    knowledge: GripperKnowledge, seed: int
) -> None:
    run = gripped(knowledge, ElasticObject(200.0, 4e-3), seed, stiffness=200.0)
    assert run.held
    assert run.true_force_n is not None
    assert run.estimated_force_n == pytest.approx(run.true_force_n, abs=0.06)
    assert run.true_force_n == pytest.approx(0.3, abs=0.07)


@pytest.mark.parametrize("stiffness", [100.0, 1000.0])
def test_of_unknown_stiffness_the_force_is_bounded_by_a_rigid_blocks(
    knowledge: GripperKnowledge, stiffness: float
) -> None:
    run = gripped(knowledge, ElasticObject(stiffness, 5e-3), 3)
    assert run.true_force_n is not None
    assert run.most_force_n is not None
    assert 0.0 < run.true_force_n <= run.most_force_n


def test_a_force_out_of_reach_is_not_called_held(knowledge: GripperKnowledge) -> None:
    run = gripped(knowledge, ElasticObject(50.0, 9e-3), 2, stiffness=50.0, target_n=1.0)
    assert run.contact_s is not None
    assert not run.held


def test_the_same_seed_grips_the_same_to_the_bit(knowledge: GripperKnowledge) -> None:
    one, other = (gripped(knowledge, ElasticObject(200.0, 4e-3), 5) for _ in range(2))
    assert np.array_equal(one["estimated_grip_force_n"], other["estimated_grip_force_n"])


def test_nothing_that_decides_reads_the_instruments(knowledge: GripperKnowledge) -> None:
    from musclewire.signals import REFERENCE_COLUMNS, RawSample

    class WithoutInstruments:
        """The rig without its instruments."""

        reference_columns = ()

        def __init__(self, rig: object) -> None:
            self._rig = rig

        def __getattr__(self, name: str) -> object:
            return getattr(self._rig, name)

        def exchange(self, command: object) -> RawSample:
            return self._rig.exchange(command)._replace(**dict.fromkeys(REFERENCE_COLUMNS))  # type: ignore[attr-defined]

    seen = gripped(knowledge, ElasticObject(200.0, 4e-3), 5)
    with open_rig(with_object("gripper", ElasticObject(200.0, 4e-3)), seed=5) as rig:
        unseen = grip(WithoutInstruments(rig), knowledge)  # type: ignore[arg-type]
    assert np.array_equal(seen["drive_voltage_v"], unseen["drive_voltage_v"])
    assert unseen.true_force_n is None
    assert unseen.estimated_force_n == seen.estimated_force_n


def test_what_was_learned_agrees_with_the_finger_and_the_wire(knowledge: GripperKnowledge) -> None:
    compliance = load_finger("lan-fan-2010").curve.endpoint_compliance_m_per_n
    # Grips end at different bends: within what the finger's own curve spans, give or take a fifth.
    assert 0.8 * min(compliance) < knowledge.curve.finger_compliance_m_per_n < 1.2 * max(compliance)
    # A wire of 35 mm, both legs, between the elastic moduli of martensite and austenite (some 20 to 80 GPa).
    section = 2 * np.pi / 4 * 1e-4**2
    assert 0.035 / (80e9 * section) < knowledge.curve.wire_compliance_m_per_n < 0.035 / (20e9 * section)


def test_what_was_learned_survives_its_file_and_another_file_is_refused(
    knowledge: GripperKnowledge, tmp_path: Path
) -> None:
    file = tmp_path / "gripper.json"
    knowledge.save(file)
    assert load_knowledge(file) == knowledge
    for text in ("", "[]", '{"format": "musclewire-gripper", "version": 1}', '{"format": "other", "version": 1}'):
        file.write_text(text)
        with pytest.raises(CallerError, match=r"^[^\n]*gripper\.json[^\n]*$"):
            load_knowledge(file)


@pytest.mark.parametrize(
    ("other", "said"),
    [
        ({"wire": "paper-125um"}, "wire paper-125um there"),
        ({"leg_length_m": 0.05}, "legs of 50 mm there"),
        ({"finger": "mine"}, "finger mine there"),
        ({"finger_stiffness_n_per_m": 500.0}, "finger stiffness 500 N/m there"),
        ({"fingers": 1}, "fingers: 1 there"),
        ({"pretension_n": 0.8}, "pretension 0.8 N there, pretension 0.71 N here"),
    ],
)
def test_another_gripper_than_the_one_learned_on_is_refused(
    knowledge: GripperKnowledge, other: dict, said: str
) -> None:
    of_another_gripper = replace(knowledge, gripper=replace(knowledge.gripper, **other))
    with open_rig("gripper") as rig, pytest.raises(CallerError, match=said):
        grip(rig, of_another_gripper)


def test_a_pretension_measured_anew_and_a_rig_that_says_less_are_no_other_gripper(knowledge: GripperKnowledge) -> None:
    knowledge.gripper.require_same(replace(knowledge.gripper, pretension_n=0.712))
    knowledge.gripper.require_same(replace(knowledge.gripper, finger=None, leg_length_m=None))


@pytest.mark.full
def test_of_unknown_stiffness_the_force_is_nearly_right_in_the_mean_over_objects_and_weather(
    knowledge: GripperKnowledge,
) -> None:
    # The power of a newton is learned in one day's air, so that one gripper has a bias of its own; each grip has other
    # draughts. Their spread of 0.06 N leaves the mean of 48 uncertain by 0.01 N.
    days = (knowledge, train_gripper("gripper", seed=2000), train_gripper("gripper", seed=2001))
    errors = []
    for seed in range(48):
        block = ElasticObject((100.0, 200.0, 500.0, 1000.0)[seed % 4], (4e-3, 5.5e-3, 7e-3, 9e-3)[seed // 4 % 4])
        run = gripped(days[seed // 16], block, seed)
        assert run.true_force_n is not None
        errors.append((run.estimated_force_n or 0.0) - run.true_force_n)
    assert abs(np.mean(errors)) < 0.04
    assert np.sqrt(np.mean(np.square(errors))) < 0.075


def test_a_closing_above_the_rigs_voltage_names_the_setting_and_the_number_that_serves() -> None:
    configuration, _ = rig_configuration("gripper")
    low = configuration.model_copy(update={"drive_amplitude": 3.5, "maximum_voltage": 4.05})
    with open_rig(low) as rig, pytest.raises(CallerError, match=r"maximum_voltage_v = 4.6 under \[settings\]"):
        close_fingers(rig)


def test_too_few_closings_are_refused_with_what_is_missing() -> None:
    with open_rig(with_object("gripper", None)) as rig:
        runs = [close_fingers(rig)]
    with pytest.raises(RecordingError, match="30 are needed"):
        mw.fit_free_closing(runs)


def test_force_is_not_learned_without_the_load_cell(knowledge: GripperKnowledge) -> None:
    with open_rig(with_object("gripper", None)) as rig:
        run = close_fingers(rig)
    cut = Recording({name: run[name] for name in run.names if name != "endpoint_force_n"}, run.metadata)
    with pytest.raises(RecordingError, match="load cell"):
        mw.fit_grip_curve([run], [mw.KnownGrip(cut, 300.0)], knowledge.free, fingers=2)


def test_a_rig_without_anything_to_grip_and_a_closing_that_cannot_be_are_refused() -> None:
    with pytest.raises(CallerError, match="nothing to grip"):
        with_object("simulated", None)
    for closing_s in (0.0, 0.3):
        with open_rig("gripper") as rig, pytest.raises(CallerError):
            close_fingers(rig, closing_s=closing_s)
