"""The list of the doctor's checks, and what is said of all that were done."""

from __future__ import annotations

from musclewire.experiment import RigCheck, SkippedCheck
from musclewire.experiment._doctor.evidence import Findings
from musclewire.experiment._doctor.examine import BELOW, LATER
from musclewire.judge import remedies


def test_every_check_has_a_name_of_its_own_and_words_and_no_words_are_without_a_check() -> None:
    rows = [row for row in (*BELOW, *LATER) if row.words]
    assert {row.words for row in rows} == set(remedies("rig"))
    assert len({row.name for row in rows}) == len(rows)
    assert all("holds" in words for words in remedies("rig").values())


def test_failed_checks_come_first_and_one_sentence_counts_all() -> None:
    checks = tuple(RigCheck(name, ok, None, "", "") for name, ok in (("a", True), ("b", False), ("c", True)))
    findings = Findings(checks, (SkippedCheck("d", "no clock"),))
    assert [check.name for check in findings.worst_first] == ["b", "a", "c"]
    assert findings.summary == "4 checks: 1 failed, 2 passed, 1 not run"
