import copy
import operator
import pickle
import sys

import numpy as np
import pytest

from musclewire.errors import CallerError, MissingExtraError, RecordingError
from musclewire.signals import Recording


@pytest.fixture
def loop():
    time_s = np.linspace(0.0, 2.0, 5)
    return Recording({"time_s": time_s, "force_n": time_s * 3.0}, {"wire": "Flexinol", "ended": "done"})


def test_columns_are_had_by_name(loop):
    assert loop["force_n"].tolist() == [0.0, 1.5, 3.0, 4.5, 6.0]
    assert "force_n" in loop
    assert "stress_pa" not in loop
    assert (len(loop), loop.names, loop.duration_s) == (5, ("time_s", "force_n"), 2.0)


@pytest.mark.parametrize(
    ("columns", "error", "says"),
    [
        ({"time_s": [0.0, 1.0], "force_N_": [0.0, 1.0]}, CallerError, "did you mean 'force_n'"),
        ({"time_s": [0.0, 1.0], "force_n": [0.0, 1.0, 2.0]}, RecordingError, r"time_s 2, force_n 3"),
        ({"time_s": [[0.0, 1.0]]}, CallerError, "column 'time_s' has shape"),
        ({"time_s": ["a", "b"]}, CallerError, "column 'time_s' must be numbers"),
        ({"force_n": [0.0, 1.0]}, RecordingError, "needs time_s, or resistance_ohm.*; got force_n"),
        ({}, RecordingError, "got no columns"),
    ],
)
def test_columns_that_make_no_recording_are_refused(columns, error, says):
    with pytest.raises(error, match=says):
        Recording(columns)


def test_the_arrays_it_was_made_from_stay_the_callers():
    time_s = np.array([0.0, 1.0])
    recording = Recording({"time_s": time_s})
    time_s[0] = -5.0
    assert recording["time_s"][0] == 0.0


def test_with_columns_and_with_metadata_make_another_recording(loop):
    more = loop.with_columns(stress_pa=np.arange(5)).with_metadata(wire=None, pretension_n=np.float64(1.7))
    assert more.names == ("time_s", "force_n", "stress_pa")
    assert dict(more.metadata) == {"wire": None, "ended": "done", "pretension_n": 1.7}
    assert type(more.metadata["pretension_n"]) is float
    assert loop.names == ("time_s", "force_n")
    assert loop.metadata["wire"] == "Flexinol"


def test_between_takes_rows_as_a_slice_does(loop):
    assert loop.between(1, 3)["time_s"].tolist() == [0.5, 1.0]
    assert len(loop.between(stop=-1)) == 4
    with pytest.raises(CallerError, match=r"counts rows, got 0\.5"):
        loop.between(0.5, 1.0)


def test_without_a_clock_a_recording_is_a_printed_loop(loop):
    table = Recording({"resistance_ohm": [3.0, 4.0], "strain_heating": [0.04, 0.0], "strain_cooling": [0.04, 0.0]})
    assert (table.is_branch_table, loop.is_branch_table) == (True, False)
    with pytest.raises(RecordingError, match="has no column 'time_s'"):
        _ = table.duration_s


def test_recordings_are_equal_when_their_numbers_are(loop):
    assert loop == loop.with_columns(force_n=loop["force_n"].copy())
    assert loop != loop.with_columns(force_n=np.zeros(5))
    assert loop != loop.with_metadata(ended="interrupted")
    assert loop != "loop"
    with_nan = loop.with_columns(estimated_strain=np.full(5, np.nan))
    assert with_nan == copy.deepcopy(with_nan)


def test_a_recording_travels_between_processes_and_stays_read_only(loop):
    arrived = pickle.loads(pickle.dumps(loop))
    assert arrived == loop
    assert not arrived["force_n"].flags.writeable


def test_in_a_notebook_it_is_a_table_with_units_and_nothing_of_the_metadata_is_html(loop):
    page = loop.with_metadata(note="<script>")._repr_html_()
    assert "<td>force_n</td><td>N</td><td>0</td><td>6</td>" in page
    assert "<script>" not in page


def test_in_a_notebook_the_main_facts_are_in_words_and_the_rest_is_counted(loop):
    stated = {"wire_length_m": 0.14, "limit_minimum_current_a": 0.0010924981791697013, "limit_wire_range_v": 10.0}
    page = loop.with_metadata(stated)._repr_html_()
    assert "wire length 140 mm" in page
    assert "limit" not in page
    assert "more in .metadata" in page


def test_pandas_gets_the_columns_and_the_metadata(loop):
    frame = loop.to_pandas()
    assert list(frame.columns) == ["time_s", "force_n"]
    assert frame.attrs["wire"] == "Flexinol"
    frame.loc[0, "force_n"] = 99.0
    assert loop["force_n"][0] == 0.0


def test_without_pandas_the_extra_is_named(loop, monkeypatch):
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(MissingExtraError, match=r'pip install "\.\[pandas\]" in the checkout'):
        loop.to_pandas()


@pytest.mark.parametrize(
    ("ask", "error", "says"),
    [
        (lambda loop: loop["force"], CallerError, "unknown column 'force'; did you mean 'force_n'"),
        (lambda loop: loop["stress_pa"], RecordingError, "has no column 'stress_pa'; it has time_s, force_n"),
        (lambda loop: operator.setitem(loop["force_n"], 0, 7.0), ValueError, "read-only"),
        (lambda loop: operator.setitem(loop.columns, "force_n", loop["time_s"]), TypeError, "assignment"),
        (lambda loop: operator.setitem(loop.metadata, "wire", "other"), TypeError, "assignment"),
        *(
            (lambda loop, key=key: loop.with_metadata({key: 1}), CallerError, "metadata key")
            for key in ("Wire", "a b", "", "1st", "format", "rows")
        ),
        *(
            (lambda loop, value=value: loop.with_metadata(note=value), CallerError, "metadata 'note'")
            for value in ([1], {"a": 1}, 2**70, "a\0b", "\ud800")
        ),
    ],
)
def test_what_a_recording_neither_has_nor_takes_is_refused(loop, ask, error, says):
    with pytest.raises(error, match=says):
        ask(loop)
