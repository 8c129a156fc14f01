"""Whether the recipe of the container works, where no container engine runs: its steps by hand in a folder, as root.

    python -m checks.container

Makes a Debian of the recipe's version by debootstrap in a temporary folder, does what each line of Containerfile says
(COPY, RUN by chroot, USER, ENTRYPOINT), and asks for the live page as the recipe's user serves it: with its token it
must answer, and without be refused. What an engine adds (namespaces, published ports) is not tried. Needs debootstrap,
root, and about three minutes; ``.ci/run`` does not run it.
"""

from __future__ import annotations

import json
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import urllib.error
import urllib.request
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from checks.fresh_environments import ROOT, built

RECIPE = ROOT / "Containerfile"
RELEASES = {"debian:12-slim": "bookworm"}
# What an engine hands in: names on the network, and certificates that this machine trusts.
FROM_HOST = {
    "etc/resolv.conf": "etc/resolv.conf",
    "etc/hosts": "etc/hosts",
    "etc/ssl/certs/ca-certificates.crt": "etc/ssl/of_this_machine.crt",
}
VARIABLES = (
    "PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin",
    "LANG=C.UTF-8",
    "PIP_CERT=/etc/ssl/of_this_machine.crt",
)
LINK = re.compile(r"http://\S+?:(?P<port>\d+)\S*token=(?P<token>[\w-]+)")


def instructions() -> list[tuple[str, str]]:
    """Return the recipe's instructions with what follows each."""
    text = re.sub(r"\\\n", " ", RECIPE.read_text("utf-8"))
    lines = [line.strip() for line in text.splitlines() if line.strip() and not line.startswith("#")]
    return [(line.split(" ", 1)[0], line.split(" ", 1)[1]) for line in lines]


@contextmanager
def mounted(system: Path) -> Iterator[None]:
    """Mount what programs expect of a system, and take it away again."""
    targets = [system / "proc", system / "dev"]
    subprocess.run(["mount", "-t", "proc", "proc", str(targets[0])], check=True)
    subprocess.run(["mount", "--rbind", "/dev", str(targets[1])], check=True)
    subprocess.run(["mount", "--make-rslave", str(targets[1])], check=True)
    try:
        yield
    finally:
        for target in reversed(targets):
            subprocess.run(["umount", "-R", "-l", str(target)], check=False)


def base(system: Path, image: str) -> None:
    """Make the system that FROM names."""
    release = RELEASES[image.rsplit("/", 1)[-1]]
    subprocess.run(["debootstrap", "--variant=minbase", release, str(system)], check=True, stdout=subprocess.DEVNULL)
    for name, target in FROM_HOST.items():
        (system / target).parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(Path("/") / name, system / target)


def follow(system: Path, context: Path) -> dict[str, str]:
    """Do what each instruction says, and return those that say how the container starts."""
    said: dict[str, str] = {}
    for word, rest in instructions():
        if word == "RUN":
            print(f"RUN {rest}", flush=True)
            subprocess.run(
                ["chroot", str(system), "env", "-i", *VARIABLES, "sh", "-c", rest],
                check=True,
                stdout=subprocess.DEVNULL,
            )
        elif word == "COPY":
            pattern, target = rest.split()
            (system / target.strip("/")).mkdir(parents=True, exist_ok=True)
            for path in context.glob(pattern):
                shutil.copy(path, system / target.strip("/"))
        else:
            said[word] = rest
    return said


def start(system: Path, said: dict[str, str]) -> subprocess.Popen[str]:
    """Start what ENTRYPOINT and CMD say, as USER and in WORKDIR."""
    words = [*json.loads(said["ENTRYPOINT"]), *json.loads(said["CMD"])]
    user = said["USER"]
    variables = [*VARIABLES, f"HOME=/home/{user}"]
    inside = ["env", "-i", *variables, "sh", "-c", 'cd "$0" && exec "$@"', said["WORKDIR"], *words]
    command = ["chroot", f"--userspec={user}", str(system), *inside]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)


def status_of(address: str, token: str = "") -> int:
    """Return the status with which an address answers who shows a token, or none."""
    request = urllib.request.Request(address, headers={"Authorization": f"Bearer {token}"} if token else {})
    try:
        with urllib.request.urlopen(request, timeout=30) as answer:
            return int(answer.status)
    except urllib.error.HTTPError as refusal:
        return refusal.code


def judge(server: subprocess.Popen[str]) -> None:
    """Ask for the state by the link that the server prints, with and without its token; exit code 1 if it is wrong."""
    assert server.stdout is not None
    shown = ""
    for line in server.stdout:
        shown += line
        if found := LINK.search(line):
            break
    else:
        sys.exit(f"FAIL: the server ended:\n{shown}")
    state = f"http://127.0.0.1:{found['port']}/api/v1/benches"
    refused, answered = status_of(state), status_of(state, found["token"])
    print(f"without the token: {refused}; with it: {answered}")
    if (refused, answered) != (401, 200):
        sys.exit("FAIL: the page must answer with its token only")


def main() -> None:
    """Follow the recipe and ask for the page."""
    steps = dict(instructions())
    with tempfile.TemporaryDirectory(prefix="musclewire-container-") as name:
        system, context = Path(name) / "system", Path(name) / "context"
        built(context / "dist", "--wheel")
        base(system, steps["FROM"])
        with mounted(system):
            server = start(system, follow(system, context))
            try:
                judge(server)
            finally:
                server.send_signal(signal.SIGTERM)
                server.wait(timeout=60)


if __name__ == "__main__":
    main()
