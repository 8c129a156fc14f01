"""From the word ``simulated`` or a rig file to a rig, and every mistake on the way."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.places import CHECKOUT

from musclewire.errors import CallerError
from musclewire.experiment import characterize, control, home
from musclewire.parameters import (
    Parameter,
    load_alloy,
    load_bench,
    load_finger,
    load_wire,
    validated,
    wire_file_text,
)
from musclewire.rigs import GuardedRig, HasTrueState, RigConfiguration, ability, open_rig, read_rig_file, rig_names
from musclewire.small_files import toml_text


@pytest.fixture
def rig_file(tmp_path: Path):
    def write(text: str) -> Path:
        path = tmp_path / "my_rig.toml"
        path.write_text(text, "utf-8")
        return path

    return write


def refusal(*arguments: object, **settings: float | str) -> str:
    with pytest.raises(CallerError) as caught:
        open_rig(*arguments, **settings)
    return str(caught.value)


def test_the_word_simulated_opens_the_papers_bench() -> None:
    facts = open_rig("simulated").metadata()
    assert facts["wire"] == "paper-100um"
    assert facts["spring_stiffness_n_per_m"] == 588.60
    assert facts["new_wire"] is False


def test_a_rig_file_chooses_wire_seed_and_settings(rig_file) -> None:
    path = rig_file('wire = "paper-125um"\nnew_wire = true\nseed = 7\n[settings]\npretension_n = "1.7 N"\nlegs = 1\n')
    assert read_rig_file(path) == RigConfiguration(
        wire="paper-125um", new_wire=True, seed=7, settings={"pretension_n": "1.7 N", "legs": 1.0}
    )
    facts = open_rig(path).metadata()
    assert (facts["wire"], facts["new_wire"], facts["seed"]) == ("paper-125um", True, 7)
    assert facts["pretension_n"] == 1.7
    assert facts["leg_length_m"] == facts["wire_length_m"]


def test_the_least_rig_file_is_the_simulated_rig(rig_file) -> None:
    assert open_rig(rig_file("kind = 'simulated'\n")).metadata() == open_rig("simulated").metadata()


def test_settings_of_the_call_win_over_those_of_the_file(rig_file) -> None:
    path = rig_file("seed = 7\n[settings]\npretension_n = 1.7\n")
    facts = open_rig(path, seed=8, pretension_n=2.5).metadata()
    assert (facts["pretension_n"], facts["seed"]) == (2.5, 8)


@pytest.mark.parametrize(("given", "newton"), [(1.7, 1.7), ("1.7 N", 1.7), ("1700 mN", 1.7), ("0.1 kgf", 0.980665)])
def test_a_setting_is_in_si_or_carries_its_unit(given: float | str, newton: float) -> None:
    assert open_rig("simulated", pretension_n=given).metadata()["pretension_n"] == pytest.approx(newton)


def test_a_temperature_may_be_given_in_celsius() -> None:
    cold, warm = (open_rig("simulated", ambient_temperature_k=t) for t in ("15 degC", 300.0))
    assert ability(cold, HasTrueState).wire_state.temperature_k == pytest.approx(288.15)
    assert ability(warm, HasTrueState).wire_state.temperature_k == pytest.approx(300.0)


@pytest.mark.parametrize("given", ["1.7", "1.7 mm", "1.7 newtonns", "much", "nan N"])
def test_a_setting_without_its_unit_or_in_a_wrong_one_is_refused(given: str) -> None:
    assert "'" + given + "'" in refusal("simulated", pretension_n=given)


@pytest.mark.parametrize(
    ("text", "hint"),
    [
        ('wyre = "paper-100um"', "unknown key 'wyre'; did you mean 'wire'?"),
        ("[settings]\npretention_n = 1.7", "unknown setting 'pretention_n'; did you mean 'pretension_n'?"),
        ("seed = -1", "seed: must be 0 or more, not -1"),
        ("legs = 2.5", "legs: must be a whole number, as 2, not 2.5"),
        ('kind = "replya"', "there is no kind of rig 'replya'; did you mean 'replay'?"),
        ('new_wire = "perhaps"', "new_wire: must be true or false, not 'perhaps'"),
        ("[settings]\npretension_n = [1]", "pretension_n: must be a number in SI or text with a unit, not a list"),
        ("settings = 3", "settings: must be a table, [settings] in TOML, not 3"),
        ('[load]\npart = "finger"', "load: must be a list: write [[load]], with two brackets, before each part"),
        ("load = []", "load is empty: give a [[load]] part, or leave load out for the bench's spring"),
        ('[surroundings]\nambient_swing = "3 degC"', "a difference of temperatures is needed, like '3 K'"),
        ("seed = ", "cannot be read"),
        ('seed = 2\nwire = "paper-100um\nlegs = 2', "cannot be read: a quote is not closed in line 2"),
        ("wire_length = 60", 'no wire of the catalogue has or survives it; for 60 mm write "60 mm"; if'),
        ("# kind = simulated\n", "states nothing"),
        (f"kind = 'simulated'\nx = {'[' * 2000}{']' * 2000}\n", "nested too deeply"),
        ("sample_period = '1 ns'", "sample_period: must be 1e-05 or more, not '1 ns'"),
    ],
)
def test_a_mistake_in_a_rig_file_is_one_line_with_a_hint(rig_file, text: str, hint: str) -> None:
    message = refusal(rig_file(text))
    assert hint in message
    assert "my_rig.toml" in message


def test_a_name_that_is_no_rig_is_answered_in_whole_sentences() -> None:
    near, far = refusal("fingr"), refusal("lever")
    assert near.endswith("did you mean 'finger'? Otherwise give the path of a TOML rig file")
    assert far.endswith(f"known: {', '.join(sorted(rig_names()))}, or give the path of a TOML rig file")


def test_what_is_not_there_a_folder_and_bytes_are_no_rig_files(tmp_path: Path) -> None:
    message = refusal(tmp_path / "nowhere.toml")
    assert "nowhere.toml" in message
    assert "'simulated'" in message
    assert "cannot be read" in refusal(tmp_path)
    path = tmp_path / "rig.toml"
    path.write_bytes(b"\xff\xfe\x00")
    assert "cannot be read" in refusal(path)


@pytest.mark.parametrize(
    ("setting", "value"),
    [
        ("pretension_n", -1.0),
        ("spring_stiffness_n_per_m", float("nan")),
        ("wire_length_m", 0.0),
        ("time_step_s", -0.001),
        ("time_step_s", 0.003),
        ("sample_period_s", 0.0),
        ("ambient_temperature_k", 0.0),
        ("shunt_resistance_ohm", -1.0),
        ("maximum_voltage_v", float("nan")),
    ],
)
def test_numbers_that_cannot_belong_to_a_bench_are_the_callers_error(setting: str, value: float) -> None:
    refusal("simulated", **{setting: value})


def wire_file(folder: Path, friction_n: float) -> Path:
    wire = load_wire("paper-125um")
    friction = Parameter(value=friction_n, unit="N", kind="fitted", source="a loop")
    path = folder / "mine.toml"
    path.write_text(
        wire_file_text("mine", "found", wire, load_alloy(wire.alloy), {"guide_friction_n": friction}), "utf-8"
    )
    return path


def test_a_wire_file_is_a_wire_and_says_what_is_known_of_its_bench(tmp_path: Path) -> None:
    path = wire_file(tmp_path, 0.0123)
    for rig in (open_rig("simulated", wire=str(path)), open_rig("simulated", wire=str(path), pretension_n=1.0)):
        assert rig.metadata()["wire"] == "mine"
        assert rig.metadata()["wire_diameter_m"] == 125e-6
        assert rig.device.spool.bench["guide_friction_n"] == 0.0123
    named = open_rig("simulated", wire=str(path), bench="dead-weight")
    assert named.device.spool.bench["guide_friction_n"] == load_bench("dead-weight").guide_friction_n.value
    assert open_rig("simulated", wire=str(path), guide_friction_n=0.05).device.spool.bench["guide_friction_n"] == 0.05


def test_a_rig_file_finds_its_wire_file_beside_itself(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    wire_file(tmp_path, 0.0123)
    (tmp_path / "rig.toml").write_text('wire = "mine.toml"\n', "utf-8")
    monkeypatch.chdir("/")
    assert open_rig(tmp_path / "rig.toml").metadata()["wire"] == "mine"


def test_a_rig_file_finds_the_fingers_of_its_parts_beside_itself(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    wire_file(tmp_path, 0.0123)
    bendy = load_finger("lan-fan-2010").model_copy(update={"name": "bendy", "geometry": {}})
    (tmp_path / "bendy.toml").write_text(toml_text(bendy.model_dump()), "utf-8")
    (tmp_path / "rig.toml").write_text(
        'pretension = "0.5 N"\n[[load]]\npart = "finger"\nfinger = "bendy.toml"\n', "utf-8"
    )
    monkeypatch.chdir("/")
    facts = open_rig(tmp_path / "rig.toml").metadata()
    assert facts["load"] == "finger"
    (tmp_path / "bendy.toml").unlink()
    assert "there is no finger file" in refusal(tmp_path / "rig.toml")


ANYTHING = st.recursive(
    st.booleans() | st.integers(-3, 3) | st.floats() | st.sampled_from(["", "3 N", "finger", "spring", "weight"]),
    lambda inner: st.lists(inner, max_size=2) | st.dictionaries(
        st.sampled_from(["part", "finger", "stiffness", "draught", "pretension_n", "force"]), inner, max_size=3
    ),
    max_leaves=6,
)  # fmt: skip


@settings(deadline=None, max_examples=200)
@given(data=st.dictionaries(st.sampled_from([*RigConfiguration.model_fields, "other"]), ANYTHING, max_size=3))
def test_whatever_a_rig_file_holds_it_is_read_or_refused_in_plain_words(data: dict[str, object]) -> None:
    message = ""
    try:
        validated(RigConfiguration, data, "rig file my_rig.toml")
    except CallerError as error:
        message = str(error)
    assert "Input should" not in message


def test_an_object_is_no_rig_and_the_message_says_how_a_device_of_ones_own_becomes_one() -> None:
    class Supply:
        """A driver of somebody's own."""

    with pytest.raises(CallerError, match="not by a Supply: a device of your own is named in a rig file"):
        open_rig(Supply())  # type: ignore[arg-type]
    with pytest.raises(CallerError, match="a GuardedRig holds a Device, and a Supply is none: it has no facts"):
        GuardedRig(Supply())  # type: ignore[arg-type]
    for drive in (characterize, lambda rig: control(rig, None), lambda rig: home(rig, None)):
        with pytest.raises(CallerError, match="a rig is driven, as open_rig returns it, not a Supply: hardware"):
            drive(Supply())


def test_a_plant_that_is_given_by_its_path_is_opened() -> None:
    with open_rig(CHECKOUT / "examples" / "plants" / "liang_rogers.toml") as rig:
        assert rig.drive_amplitude_v > rig.sense_voltage_v


def test_a_run_that_would_never_end_is_refused_before_anything_is_heated() -> None:
    with (
        open_rig("simulated") as rig,
        pytest.raises(CallerError, match=r"a run of 9e\+12 s would take 1.8e\+14 samples"),
    ):
        characterize(rig, cycles=99_999_999_999)
