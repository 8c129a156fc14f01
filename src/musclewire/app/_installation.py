"""What is installed here, as a report of a bug needs it: versions, extras, the machine, the commit of a checkout."""

from __future__ import annotations

import os
import platform
import re
import subprocess
import sys
from importlib.metadata import PackageNotFoundError, requires, version
from pathlib import Path

from pydantic import ConfigDict

from musclewire.app._answer import AnswerModel
from musclewire.manifest import loaded, offered

# Name at the beginning of a requirement, and the extra at its end.
REQUIREMENT = re.compile(r"([\w.-]+).*?(?:;.*\bextra\s*==\s*['\"]([\w.-]+)['\"])?$")
# Extras of those who change musclewire.
OF_DEVELOPERS = ("test", "oracles", "dev", "docs")
# What Numba compiles with, which it needs in one version only.
COMPILER = "llvmlite"


class Installation(AnswerModel):
    """What is installed: our version, and of each package that we need; None for what is not there.

    Versions that parts outside the core state of themselves, as the firmware's protocol, are among its keys.
    """

    model_config = ConfigDict(extra="allow")

    version: str
    commit: str | None
    python: str
    system: str
    processors: int | None
    packages: dict[str, str | None]
    extras: dict[str, bool]


def installation() -> Installation:
    """Look up what is installed; none of the packages is imported for it."""
    needed = requirements()
    packages = {name: installed_version(name) for names in [*needed.values(), [COMPILER]] for name in names}
    extras = {extra: all(packages[name] for name in names) for extra, names in sorted(needed.items()) if extra}
    return Installation(
        version=version("musclewire"),
        commit=commit_of(Path(__file__).resolve().parents[3]),
        python=f"{platform.python_version()} ({platform.python_implementation()})",
        system=system_text(),
        processors=os.cpu_count(),
        packages=packages,
        extras=extras,
        **{key: loaded(place) for key, place in offered("versions").items()},
    )


def requirements() -> dict[str, list[str]]:
    """Return the packages that musclewire itself ("") and each extra for users need, but for extras of other extras."""
    found: dict[str, list[str]] = {"": []}
    for line in requires("musclewire") or ():
        match = REQUIREMENT.match(line)
        if match and match[1] != "musclewire" and (match[2] or "") not in OF_DEVELOPERS:
            found.setdefault(match[2] or "", []).append(match[1])
    return found


def installed_version(name: str) -> str | None:
    """Return the version of an installed package, None if it is missing."""
    try:
        return version(name)
    except PackageNotFoundError:
        return None


def commit_of(checkout: Path) -> str | None:
    """Return the commit of a checkout that musclewire runs from, None if it was installed from a package."""
    if not ((checkout / ".git").exists() and (checkout / "pyproject.toml").is_file()):
        return None
    git = ["git", "-C", str(checkout)]
    try:
        name = subprocess.run([*git, "rev-parse", "--short=12", "HEAD"], capture_output=True, text=True, check=True)
        changed = subprocess.run([*git, "status", "--porcelain"], capture_output=True, text=True, check=True)
    except (OSError, subprocess.CalledProcessError):
        return None
    return name.stdout.strip() + (", with changes" if changed.stdout.strip() else "")


def system_text() -> str:
    """Return the operating system by its own name and release, and the machine's kind."""
    try:
        release = platform.freedesktop_os_release()["PRETTY_NAME"]
    except (OSError, KeyError):
        release = platform.platform()
    return f"{release}, {sys.platform}, {platform.machine()}"


def installation_text(found: Installation) -> str:
    """Return what is installed as lines for people, the version alone in the first."""
    missing = [name for name, there in found.extras.items() if not there]
    rows = {
        "commit": found.commit,
        "Python": found.python,
        "system": f"{found.system}, {found.processors} processors",
        "packages": ", ".join(f"{name} {number}" for name, number in found.packages.items() if number),
        "extras": ", ".join(name for name, there in found.extras.items() if there) or "none",
        "not there": ", ".join(missing),
        **{
            key.partition("_")[0]: f"{key.partition('_')[2]} {number}"
            for key, number in (found.model_extra or {}).items()
        },
    }
    return "\n".join([f"musclewire {found.version}", *(f"{name:11}{text}" for name, text in rows.items() if text)])
