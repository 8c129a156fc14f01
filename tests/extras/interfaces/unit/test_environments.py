"""The Gymnasium environments: what Gymnasium asks of them, and that both are the rig that the command line drives."""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

from musclewire.errors import CallerError, NumericsError
from musclewire.experiment import characterize
from musclewire.extras.interfaces import ENVIRONMENT, WireVectorEnv
from musclewire.identify import fit
from musclewire.rigs import RigConfiguration, open_rig
from musclewire.sensing import ESTIMATORS, EstimatorSetup, SensingModel

pytestmark = pytest.mark.slow

# No noise, a fine converter, and steps of one length: then both environments read the same numbers.
QUIET = {
    "acquisition_noise_v": 0.0,
    "displacement_noise_m": 0.0,
    "acquisition_bits": 24.0,
    "time_step_s": 0.01,
}
SHORT = {"hold_s": 0.5, "approach_s": 0.5, "increments": 2}


def wire_env(rig: Any = "simulated", **options: Any) -> Any:
    """Return the single environment, as the registry makes it and without Gymnasium's wrappers."""
    return gymnasium.make(ENVIRONMENT, rig=rig, **options).unwrapped


@pytest.fixture(scope="module")
def model() -> SensingModel:
    with open_rig("simulated") as rig:
        return fit(characterize(rig, cycles=1, period_s=30.0))


def drives(samples: int, lanes: int = 1) -> np.ndarray:
    """Return drives that heat the wire, cool it and heat it again, (n_samples, n_lanes, 1)."""
    wave = np.sin(np.arange(samples)[:, None] * 0.11 + np.arange(lanes) * 0.4)
    return wave[:, :, None]


@pytest.mark.parametrize("episode", ["staircase", "random"])
def test_gymnasium_finds_nothing_wrong(episode: str, model: SensingModel) -> None:
    for known in (None, model):
        env = gymnasium.make(ENVIRONMENT, episode=episode, model=known).unwrapped
        env.action_space.seed(1)
        check_env(env)


@pytest.mark.parametrize("part", [0.0, 1.0])
def test_an_estimate_on_either_branch_is_in_the_space(part: float, model: SensingModel) -> None:
    """A filter that knows the branch is at its end beyond the range of the mean curve."""
    ends_ohm = np.array(model.valid_resistance_ohm)
    on_branch = part * model.strain_heating(ends_ohm) + (1.0 - part) * model.strain_cooling(ends_ohm)
    env = wire_env(episode=SHORT, model=model)
    env.reset(seed=1)
    low, high = env.observation_space.low[5], env.observation_space.high[5]
    assert (on_branch >= low).all()
    assert (on_branch <= high).all()


def test_the_registry_makes_both_kinds() -> None:
    assert isinstance(gymnasium.make_vec(ENVIRONMENT, num_envs=2), WireVectorEnv)
    synchronous = gymnasium.make_vec(ENVIRONMENT, num_envs=2, vectorization_mode="sync")
    assert type(synchronous.envs[0].unwrapped) is type(wire_env())


def test_an_observation_holds_what_a_rig_reads_and_no_more() -> None:
    """The rig itself is the oracle: the same drives give the same voltages."""
    env = wire_env(episode=SHORT)
    observed, _ = env.reset(seed=3)
    with open_rig("simulated", seed=int(np.random.Generator(np.random.PCG64(3)).integers(2**31))) as rig:
        sample = rig.exchange(rig.sense_voltage_v)
        resistance = sample.wire_voltage_v / sample.shunt_voltage_v * rig.shunt_resistance_ohm
        assert observed.tolist() == [
            sample.wire_voltage_v, sample.shunt_voltage_v, resistance, sample.drive_voltage_v, 0.015,
        ]  # fmt: skip
        for action in drives(20)[:, 0]:
            observed, reward, *_, info = env.step(action)
            span_v = rig.maximum_voltage_v - rig.sense_voltage_v
            sample = rig.exchange(rig.sense_voltage_v + 0.5 * (action[0] + 1.0) * span_v)
            assert observed[:2].tolist() == [sample.wire_voltage_v, sample.shunt_voltage_v]
            assert sample.displacement_m is not None
            assert info["measured_strain"] == sample.displacement_m / rig.leg_length_m
            assert reward == -100.0 * abs(0.015 - info["measured_strain"])


@pytest.mark.parametrize("estimator", [None, "polynomial"])
def test_a_wire_in_the_vector_is_the_wire_of_the_single_environment(model: SensingModel, estimator: str | None) -> None:
    single = wire_env(episode=SHORT, model=model, estimator=estimator, **QUIET)
    vector = WireVectorEnv(3, episode=SHORT, model=model, estimator=estimator, **QUIET)
    alone, _ = single.reset(seed=1)
    together, _ = vector.reset(seed=2)
    np.testing.assert_allclose(together[1], alone, rtol=1e-9, atol=1e-12)
    for actions in drives(60, 3):
        alone, reward, terminated, truncated, info = single.step(actions[1])
        together, rewards, ended, cut, infos = vector.step(actions)
        np.testing.assert_allclose(together[1], alone, rtol=1e-9, atol=1e-12)
        assert rewards[1] == pytest.approx(reward, rel=1e-9)
        assert infos["measured_strain"][1] == pytest.approx(info["measured_strain"], rel=1e-9, abs=1e-12)
        assert (ended[1], cut[1]) == (terminated, truncated)
    assert truncated


def test_an_estimator_of_the_vector_has_a_compiled_tick(model: SensingModel, monkeypatch: pytest.MonkeyPatch) -> None:
    plain = type(ESTIMATORS.make("filter", EstimatorSetup(model, 1.0, 0.05)))
    monkeypatch.delattr(plain, "compiled_tick")
    with pytest.raises(CallerError, match="take WireEnv"):
        WireVectorEnv(2, model=model)
    with pytest.raises(CallerError, match="polynomial"):
        WireVectorEnv(2, model=model, estimator="polinomial")


def test_the_vectors_noise_is_that_of_the_rigs_instruments() -> None:
    """Fifty readings of a converter, each rounded, against one number of the same variance."""
    count = 400
    vector = WireVectorEnv(count, episode=SHORT)
    many = vector.reset(seed=5)[0]
    single = [wire_env(episode=SHORT).reset(seed=seed)[0] for seed in range(count)]
    for column in (0, 1):
        ours, theirs = many[:, column], np.array(single)[:, column]
        assert ours.mean() == pytest.approx(theirs.mean(), abs=4 * theirs.std() * (2 / count) ** 0.5)
        assert ours.std() == pytest.approx(theirs.std(), rel=4 / (2 * count) ** 0.5)


def test_few_readings_of_a_quiet_converter_are_rounded_one_by_one() -> None:
    few = {"acquisition_noise_v": 1e-5, "acquisition_readings": 2.0}
    vector = WireVectorEnv(5, episode=SHORT, **few)
    step_v = 2.0 * 10.0 / 2.0**16
    in_steps = vector.reset(seed=5)[0][:, :2] / (0.5 * step_v)
    np.testing.assert_allclose(in_steps, in_steps.round(), atol=1e-6)


def rollout(env: Any, seed: int, samples: int, lanes: int) -> np.ndarray:
    """Return all observations and rewards of a run."""
    rows = [env.reset(seed=seed)[0]]
    for actions in drives(samples, lanes):
        observed, rewards, *_ = env.step(actions)
        rows.append(np.column_stack([observed, rewards]))
    return np.concatenate([row.ravel() for row in rows])


def test_the_same_seed_gives_the_same_run_and_another_one_does_not() -> None:
    env = WireVectorEnv(2, episode={**SHORT, "targets": "random"})
    first, again, other = (rollout(env, seed, 70, 2) for seed in (7, 7, 8))
    assert np.array_equal(first, again)
    assert not np.array_equal(first, other)


def test_a_wire_does_not_notice_how_many_others_there_are() -> None:
    few, many = (WireVectorEnv(count, episode={**SHORT, "targets": "random"}) for count in (2, 18))
    few.reset(seed=4)
    many.reset(seed=4)
    for actions in drives(70, 18):
        here, there = few.step(actions[:2]), many.step(actions)
        for ours, theirs in zip(here[:4], there[:4], strict=True):
            assert np.array_equal(ours, theirs[:2])


def test_an_ended_wire_begins_its_next_episode_cold_in_the_next_step() -> None:
    env = WireVectorEnv(2, episode={**SHORT, "targets": "random"})
    first, _ = env.reset(seed=1)
    samples = 10 + 5 * 10
    for sample in range(1, samples + 1):
        observed, rewards, terminated, truncated, _ = env.step(np.ones((2, 1)))
        assert truncated.tolist() == [sample == samples] * 2
        assert not terminated.any()
    observed, rewards, _, truncated, _ = env.step(np.ones((2, 1)))
    assert rewards.tolist() == [0.0, 0.0]
    assert not truncated.any()
    np.testing.assert_allclose(observed[:, :4], first[:, :4], rtol=0.05)
    assert not np.array_equal(observed[:, 4], first[:, 4]), "an episode has targets of its own"


def test_the_protection_ends_an_episode_in_both_at_the_same_sample() -> None:
    # The amplifier's steps round this maximum up: what is out is a little more, and no command to be refused.
    limits = {"maximum_voltage": "3.3 V", "limits": {"maximum_temperature": "60 degC"}}
    configuration = RigConfiguration.model_validate(limits)
    single, vector = (
        wire_env(configuration, episode=SHORT, **QUIET),
        WireVectorEnv(1, configuration, episode=SHORT, **QUIET),
    )
    single.reset(seed=1)
    vector.reset(seed=1)
    sample = 0
    while True:
        sample += 1
        observed, reward, terminated, truncated, info = single.step(np.ones(1))
        together, rewards, ended, cut, infos = vector.step(np.ones((1, 1)))
        np.testing.assert_allclose(together[0], observed, rtol=1e-9)
        assert rewards[0] == pytest.approx(reward)
        assert (ended[0], cut[0]) == (terminated, truncated)
        if terminated:
            break
    assert info["event"] == infos["event"][0] == "over_temperature"
    assert reward == pytest.approx(-100 * 0.03 * (60 - sample + 1))
    assert observed[3] == 0.0
    with pytest.raises(CallerError, match="the protection has ended it"):
        single.step(np.ones(1))


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"num_envs": 0}, "at least 1"),
        ({"rig": RigConfiguration.model_validate({"surroundings": {"draught": 0.1}})}, "moving air"),
        ({"sample_period_s": 0.002}, "longer"),
    ],
)
def test_what_the_vector_cannot_simulate_is_refused_in_one_line(changes: dict[str, Any], said: str) -> None:
    with pytest.raises(CallerError, match=said):
        WireVectorEnv(**{"num_envs": 1, **changes})


@pytest.mark.parametrize("make", [wire_env, WireVectorEnv])
def test_a_step_without_a_reset_a_wrong_action_and_an_unknown_option_are_refused_in_one_line(make: Any) -> None:
    env = make(episode=SHORT)
    with pytest.raises(CallerError, match="call reset"):
        env.step(np.zeros(env.action_space.shape))
    with pytest.raises(CallerError, match="'reset_mask'"):
        env.reset(options={"reset_mask": None})
    env.reset(seed=1)
    with pytest.raises(CallerError, match="an action is an array of shape"):
        env.step(np.full(env.action_space.shape, np.nan))


def test_gymnasiums_own_wrappers_of_vectors_work_around_it() -> None:
    """Statistics of episodes rest on the autoreset that the metadata declare; observations are rescaled by bounds."""
    counted = gymnasium.wrappers.vector.RecordEpisodeStatistics(WireVectorEnv(2, episode=SHORT))
    env = gymnasium.wrappers.vector.RescaleObservation(counted, -1.0, 1.0)
    env.reset(seed=1)
    total = np.zeros(2)
    for _ in range(60):
        observed, rewards, _, truncated, infos = env.step(np.zeros((2, 1)))
        total += rewards
        assert (np.abs(observed) <= 1.0).all()
    assert truncated.all()
    np.testing.assert_allclose(infos["episode"]["r"], total)
    assert infos["episode"]["l"].tolist() == [60, 60]


def test_wires_of_several_rigs_take_turns() -> None:
    rigs = [RigConfiguration.model_validate({"settings": {"pretension_n": force_n}}) for force_n in (1.5, 2.2)]
    env = WireVectorEnv(4, rigs, episode=SHORT, **QUIET)
    env.reset(seed=1)
    for _ in range(40):
        observed, *_ = env.step(np.full((4, 1), 0.6))
    assert np.array_equal(observed[:2], observed[2:])
    assert not np.array_equal(observed[0], observed[1])


THIN = {"wire": "flexinol-0.025-lt", "settings": {"pretension_n": 0.1, "spring_stiffness_n_per_m": 10.0}}
# A thin wire is heated within a sample, and its resistance jumps by more than that of any other.
THIN_LIMITS = {"maximum_temperature": "300 degC", "jump_share": 0.9}


def test_a_simulation_that_its_steps_do_not_resolve_is_an_error_and_no_result() -> None:
    rig = RigConfiguration.model_validate({**THIN, "limits": THIN_LIMITS})
    coarse, fine = WireVectorEnv(1, rig, episode=SHORT, time_step_s=0.05), WireVectorEnv(1, rig, episode=SHORT)
    for env in (coarse, fine):
        env.reset(seed=1)
        truncated = np.zeros(1)
        while not truncated.any():
            _, _, terminated, truncated, _ = env.step(np.full((1, 1), 0.6))
            assert not terminated.any()
    with pytest.raises(NumericsError, match="time_step_s"):
        coarse.step(np.ones((1, 1)))
    fine.step(np.ones((1, 1)))
