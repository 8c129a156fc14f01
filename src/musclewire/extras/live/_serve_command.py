"""The command that shows rigs on a page and takes commands from it: serve."""

from __future__ import annotations

import re
import sys
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from musclewire.app import CPU, REAL_TIME_PRIORITY, SEED, StoppedCommand, complete_rigs, own_help, say, show
from musclewire.errors import CallerError
from musclewire.extras.live._options import HOST, OPEN, PORT, TOKEN_FILE

if TYPE_CHECKING:
    from musclewire.extras.live._bench_handle import BenchHandle
    from musclewire.extras.live._server.running import RunningServer, ServerSettings

Rigs = Annotated[
    list[str] | None,
    typer.Argument(
        metavar="RIG",
        help="Rigs to show next to each other: names or rig files, as for other commands.",
        show_default="simulated",
        autocompletion=complete_rigs,
    ),
]


@dataclass(frozen=True)
class AddressOptions:
    """Where the server listens, and to whom."""

    host: Annotated[str, HOST] = "127.0.0.1"
    port: Annotated[int, PORT] = 8765
    token_file: Annotated[Path | None, TOKEN_FILE] = None
    open: Annotated[bool, OPEN] = False


@dataclass(frozen=True)
class LoopTimingOptions:
    """How the loops keep their time."""

    cpu: Annotated[int | None, CPU] = None
    real_time_priority: Annotated[bool, REAL_TIME_PRIORITY] = False


def serve(
    address: AddressOptions,
    loop: LoopTimingOptions,
    rig: Rigs = None,
    output: Annotated[Path, own_help("--output", "Folder of the session: its recordings and models.")] = Path(
        "musclewire-session"
    ),
    seed: Annotated[int | None, SEED] = None,
) -> None:
    """Show a wire live on a page: measure, control, record and stop it there."""
    import asyncio

    from musclewire.extras.live._server.running import serve as serve_session
    from musclewire.rigs import require_rig

    rigs = rig or ["simulated"]
    for name in rigs:
        require_rig(name)  # a rig that does not exist is an error before anybody connects
    if loop.cpu is not None and len(rigs) > 1:
        raise CallerError(f"--cpu keeps one loop on one core: leave it out for {len(rigs)} rigs")
    settings = settings_from(address, loop, output)
    handles = handles_of(rigs, loop, settings.folder, seed)
    ended = asyncio.run(serve_session(handles, settings, lambda running: announce(running, address)))
    if ended is not None:
        raise StoppedCommand(128 + ended, "every drive is off")


def settings_from(options: AddressOptions, loop: LoopTimingOptions, folder: Path) -> ServerSettings:
    """Return how the session is served, its folder made."""
    from musclewire.extras.live._server.access import new_token, own_token, read_token
    from musclewire.extras.live._server.running import ListenAddress, ServerSettings

    address = ListenAddress(options.host, options.port)
    if options.token_file is not None:
        token = read_token(options.token_file)
    else:
        token = (own_token() if address.is_local else None) or new_token()
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise CallerError(f"--output {folder} cannot be made: {error.strerror or error}") from None
    return ServerSettings(folder.resolve(), address, token, cpu=loop.cpu)


def handles_of(rigs: Sequence[str], loop: LoopTimingOptions, folder: Path, seed: int | None) -> list[BenchHandle]:
    """Return a bench for each rig, none of them started."""
    from musclewire.extras.live._bench_handle import BenchHandle, BenchSettings

    return [
        BenchHandle(BenchSettings(name, rig, folder, seed, loop.cpu, loop.real_time_priority))
        for name, rig in zip(identifiers(rigs), rigs, strict=True)
    ]


def identifiers(rigs: Sequence[str]) -> list[str]:
    """Return a name for each rig that fits into addresses and names of files; equal ones are numbered."""
    seen: Counter[str] = Counter()
    found = []
    for rig in rigs:
        name = re.sub(r"[^A-Za-z0-9_-]+", "-", Path(rig).stem).strip("-") or "rig"
        seen[name] += 1
        found.append(name if seen[name] == 1 else f"{name}-{seen[name]}")
    return found


def announce(running: RunningServer, options: AddressOptions) -> None:
    """Print the link of the page, and what to know about who can open it."""
    address = running.address
    if address.port != options.port:
        say(f"port {options.port} is in use: this is port {address.port}")
    if not address.is_local:
        say(
            "warning: whoever has the link and can reach this machine can heat the wire, and the connection is not "
            "encrypted; on a network that is not your own leave out --host and use a tunnel: "
            f"ssh -L {address.port}:localhost:{address.port} THIS_MACHINE"
        )
    if options.token_file is None:
        say("the page of this session, until Ctrl-C:")
        show(running.link)
    else:  # whoever named the file has the token, and what is printed is often kept
        say(f"the page of this session, until Ctrl-C; open it with /?token= and the token of {options.token_file}:")
        show(address.url)
    sys.stdout.flush()
    if options.open:
        import webbrowser

        webbrowser.open(running.link)
