"""Control of a bench: one at a time, handed over when its holder says so, and lost with its holder."""

from __future__ import annotations

from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, precondition, rule

from musclewire.extras.live._server.access import LEASE_AT_REST_S, BenchControl, RequestOutcome
from musclewire.extras.live._silence import LEASE_S


def test_whoever_asks_first_has_control_and_the_next_one_asks_for_it() -> None:
    control = BenchControl()
    assert control.ask("a", "Ann", 0.0) is RequestOutcome.YOURS
    assert control.ask("b", "Ben", 0.1) is RequestOutcome.ASKED
    assert control.ask("c", "Cid", 0.2) is RequestOutcome.BUSY
    assert control.holds("a", 0.2)
    assert not control.holds("b", 0.2)


def test_the_holder_gives_or_keeps_and_nobody_else_answers() -> None:
    control = BenchControl()
    control.ask("a", "Ann", 0.0)
    control.ask("b", "Ben", 0.1)
    assert not control.answer("b", True, 0.1)
    assert not control.answer("c", True, 0.1)
    assert not control.answer("a", False, 0.1)
    assert control.asking is None
    control.ask("b", "Ben", 0.2)
    assert control.answer("a", True, 0.3)
    assert control.holds("b", 0.3)
    assert not control.holds("a", 0.3)


def test_a_silent_holder_loses_control_after_the_lease_and_not_before() -> None:
    control = BenchControl()
    control.ask("a", "Ann", 0.0)
    assert control.end_lost(LEASE_S) is None
    control.sign_of_life("a", LEASE_S)
    assert control.end_lost(2 * LEASE_S) is None
    lost = control.end_lost(2 * LEASE_S + 0.01)
    assert lost is not None
    assert lost.name == "Ann"
    assert control.holder is None


def test_a_late_sign_of_life_brings_no_lease_back() -> None:
    control = BenchControl()
    control.ask("a", "Ann", 0.0)
    control.sign_of_life("a", LEASE_S + 0.01)
    assert not control.holds("a", LEASE_S + 0.01)
    assert control.end_lost(LEASE_S + 0.02) is not None


def test_who_asked_comes_next_when_the_holder_leaves() -> None:
    control = BenchControl()
    control.ask("a", "Ann", 0.0)
    control.ask("b", "Ben", 0.2)
    assert control.leave("a")
    assert control.holds("b", 0.3)


def test_control_is_not_given_to_somebody_who_asked_and_is_gone() -> None:
    control = BenchControl()
    control.ask("a", "Ann", 0.0)
    control.ask("b", "Ben", 0.0)
    control.sign_of_life("a", 0.9 * LEASE_S)
    assert not control.answer("a", True, 1.1 * LEASE_S)
    assert control.holds("a", 1.1 * LEASE_S)


class Leases(RuleBasedStateMachine):
    """Three people and a clock: whatever they do, nobody has control who gave no sign, and never two."""

    def __init__(self) -> None:
        super().__init__()
        self.control, self.now_s = BenchControl(), 0.0
        self.seen: dict[str, float] = {}

    people = st.sampled_from("abc")

    @rule(passed_s=st.floats(0.0, 1.0))
    def time_passes(self, passed_s: float) -> None:
        self.now_s += passed_s

    @rule(who=people)
    def asks(self, who: str) -> None:
        before = self.control.holder
        outcome = self.control.ask(who, who.upper(), self.now_s)
        if before is None:
            self.seen[who] = self.now_s
        if outcome is RequestOutcome.ASKED:
            self.seen[who] = self.now_s

    @rule(who=people)
    def gives_a_sign(self, who: str) -> None:
        self.control.sign_of_life(who, self.now_s)
        self.seen[who] = self.now_s

    @rule(who=people, give=st.booleans())
    def answers(self, who: str, give: bool) -> None:
        held, holder = self.control.holds(who, self.now_s), self.control.holder
        if self.control.answer(who, give, self.now_s):
            assert held
            assert give
        elif holder is not None:
            assert self.control.holder is holder

    @rule(who=people)
    def leaves(self, who: str) -> None:
        self.control.leave(who)
        assert self.control.holder is None or self.control.holder.key != who

    @precondition(lambda self: self.control.holder is not None)
    @rule()
    def is_looked_after(self) -> None:
        self.control.end_lost(self.now_s)
        assert self.control.holder is None or self.control.holder.is_there(self.now_s, LEASE_S)

    @invariant()
    def nobody_has_control_without_a_recent_sign(self) -> None:
        holding = [who for who in "abc" if self.control.holds(who, self.now_s)]
        assert len(holding) <= 1
        for who in holding:
            assert self.now_s - self.seen[who] <= LEASE_S + 1e-9

    @invariant()
    def nobody_asks_themselves(self) -> None:
        holder, asking = self.control.holder, self.control.asking
        assert holder is None or asking is None or holder.key != asking.key


TestLeases = Leases.TestCase
TestLeases.settings = settings(max_examples=60, stateful_step_count=30, deadline=None)


def test_at_rest_a_moment_without_a_sign_costs_nobody_control() -> None:
    control = BenchControl()
    control.ask("a", "Ada", 0.0)
    control.lease_s = LEASE_AT_REST_S
    assert control.end_lost(LEASE_AT_REST_S) is None
    control.lease_s = LEASE_S  # a run that heats begins
    lost = control.end_lost(LEASE_AT_REST_S)
    assert lost is not None
    assert lost.name == "Ada"
