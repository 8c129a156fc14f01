"""Whether everything that musclewire needs can be had, compiled, where it is not run: Windows and macOS.

    python -m checks.platforms

Resolves the dependencies and all extras of users for each platform and Python with uv, from packages with compiled
files for that platform only. Resolved is not run: nothing is executed. Exit code 1 if one cannot be resolved.
"""

from __future__ import annotations

import os
import subprocess
import sys

from checks.fresh_environments import ROOT
from checks.package import extras_of_users

PLATFORMS = {
    "Windows, x86-64": "x86_64-pc-windows-msvc",
    "macOS, Apple silicon": "aarch64-apple-darwin",
    "macOS, x86-64": "x86_64-apple-darwin",
}
PYTHONS = ("3.11", "3.12", "3.13", "3.14")


def resolved(platform: str, python: str, extras: list[str]) -> tuple[int, str]:
    """Return how many packages are needed on a platform, and what uv says if they cannot be had."""
    options = ["--only-binary", ":all:", "--python-platform", platform, "--python-version", python, "--no-annotate"]
    chosen = [word for extra in extras for word in ("--extra", extra)]
    command = ["uv", "pip", "compile", "--quiet", "--no-config", "--no-header", *options, *chosen, "pyproject.toml"]
    variables = {**os.environ, "SSL_CERT_FILE": os.environ.get("PIP_CERT", os.environ.get("SSL_CERT_FILE", ""))}
    variables = {name: value for name, value in variables.items() if name != "SSL_CERT_FILE" or value}
    done = subprocess.run(command, cwd=ROOT, env=variables, capture_output=True, text=True, check=False)
    return done.stdout.count("=="), "" if done.returncode == 0 else done.stderr.strip()


def main() -> None:
    """Resolve every platform and Python without and with the extras; print a line for each."""
    failed = 0
    for name, platform in PLATFORMS.items():
        for python in PYTHONS:
            for what, extras in (("without extras", []), ("with all extras", sorted(extras_of_users()))):
                packages, problem = resolved(platform, python, extras)
                failed += bool(problem)
                said = f"FAIL\n{problem}" if problem else f"{packages} packages, resolved, not run"
                print(f"{name:22}Python {python}, {what:16}{said}")
    sys.exit(failed > 0)


if __name__ == "__main__":
    main()
