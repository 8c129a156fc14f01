"""The check of the package tries every extra that users install; the check itself runs in CI (checks/package.py)."""

from __future__ import annotations

from checks.package import actions, extras_of_users


def test_every_extra_of_users_has_an_action_that_needs_it() -> None:
    assert {row["extra"] for row in actions()} == extras_of_users()


def test_every_action_is_a_command_or_python() -> None:
    for row in actions():
        assert ("command" in row) != ("python" in row)
        assert set(row) <= {"extra", "command", "python", "works"}
