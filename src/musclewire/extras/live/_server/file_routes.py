"""HTTP routes of the session's recordings, and of the pages: by name from their folders, and nothing else."""

from __future__ import annotations

import asyncio
import re
import stat
import sys
from importlib.resources import files
from pathlib import Path
from typing import Annotated

from fastapi import APIRouter, HTTPException, Query
from starlette.requests import Request
from starlette.responses import FileResponse, Response
from starlette.staticfiles import StaticFiles

from musclewire.errors import CallerError
from musclewire.extras.live._server.bench_routes import PROBLEMS, SessionOf
from musclewire.extras.live._server.http_messages import RecordingList, RecordingSummary

RECORDINGS = (".h5",)
# Letters and digits of ASCII first, then also blank, dot, hyphen and underscore: no separator, no drive, no "..".
NAME = re.compile(r"[A-Za-z0-9](?:[A-Za-z0-9 _-]|\.(?!\.)){0,99}")
MAX_LISTED = 500


def named_file(folder: Path, name: str) -> Path:
    """Return the path of a session's recording. CallerError for anything else, with the same words whatever it is."""
    if NAME.fullmatch(name) and name.endswith(RECORDINGS):
        path = folder / name
        if is_inside(path, folder):
            return path
    raise CallerError(
        f"no file of that name with {' or '.join(RECORDINGS)} in the session's folder: choose one that is listed"
    )


def is_inside(path: Path, folder: Path) -> bool:
    """Return whether a path is a regular file that lies in a folder itself; a link that leads elsewhere is not."""
    try:
        real = path.resolve(strict=True)
        return real.parent == folder.resolve(strict=True) and stat.S_ISREG(real.stat().st_mode)
    except (OSError, RuntimeError):
        return False


def session_files(folder: Path, suffixes: tuple[str, ...]) -> list[RecordingSummary]:
    """Return the files of a session that can be named, the newest first."""
    found = []
    for path in folder.iterdir() if folder.is_dir() else ():
        if NAME.fullmatch(path.name) and path.name.endswith(suffixes) and is_inside(path, folder):
            status = path.stat()
            found.append(RecordingSummary(name=path.name, bytes=status.st_size, modified_s=status.st_mtime))
    return sorted(found, key=lambda one: -one.modified_s)[:MAX_LISTED]


ROUTES = APIRouter(prefix="/api/v1/recordings", responses=PROBLEMS, tags=["recordings"])
PAGE = Path(str(files("musclewire.extras.live"))) / "page"
READING_S = 60.0
# One recording is read at a time: the machine belongs to the loop.
ONE_AT_A_TIME = asyncio.Semaphore(1)


@ROUTES.get("")
async def list_recordings(session: SessionOf) -> RecordingList:
    """List the recordings in the session's folder, the newest first."""
    found = await asyncio.to_thread(session_files, session.folder, RECORDINGS)
    return RecordingList(recordings=found)


def recording_path(session: SessionOf, name: str) -> Path:
    """Return the path of a recording by its name."""
    try:
        return named_file(session.folder, name)
    except CallerError as error:
        raise HTTPException(404, str(error)) from None


@ROUTES.get("/{name}", response_class=FileResponse)
async def download_recording(session: SessionOf, name: str) -> Response:
    """Download a recording as the file it is."""
    return FileResponse(recording_path(session, name), media_type="application/x-hdf5", filename=name)


@ROUTES.get("/{name}/rows")
async def recording_rows(
    session: SessionOf, name: str, points: Annotated[int, Query(ge=2, le=20_000)] = 1000
) -> Response:
    """Return the columns of a recording, thinned to a number of points, for comparing it with another run."""
    path = recording_path(session, name)
    async with ONE_AT_A_TIME:
        code, out, err = await read_elsewhere(path, points)
    if code != 0:
        raise HTTPException(422, err.decode("utf-8", "replace").strip()[:300] or "the recording cannot be read")
    return Response(out, media_type="application/json")


async def read_elsewhere(path: Path, points: int) -> tuple[int, bytes, bytes]:
    """Read a recording in a process of its own: while HDF5 reads a large file, this one must answer."""
    module = "musclewire.extras.live._server.thinned_recording"
    process = await asyncio.create_subprocess_exec(
        *(sys.executable, "-P", "-m", module, str(path), str(points)),
        stdin=asyncio.subprocess.DEVNULL,
        stdout=asyncio.subprocess.PIPE,
        stderr=asyncio.subprocess.PIPE,
    )
    try:
        async with asyncio.timeout(READING_S):
            out, err = await process.communicate()
    except TimeoutError:
        raise HTTPException(422, f"the recording has not been read within {READING_S:g} s: download it") from None
    finally:
        if process.returncode is None:
            process.kill()
    return int(process.returncode or 0), out, err


class PageFiles(StaticFiles):
    """The page's own files: from one folder of the package, no links followed, asked for again each time."""

    def file_response(self, *args: object, **kwargs: object) -> Response:
        """Return a file, or that it has not changed."""
        response = super().file_response(*args, **kwargs)  # type: ignore[arg-type]
        response.headers["Cache-Control"] = "no-cache"
        return response


async def first_page(_request: Request) -> Response:
    """Return the page."""
    path = PAGE / "index.html"
    if not path.is_file():
        raise HTTPException(404, "this installation has no page")
    return FileResponse(path, media_type="text/html; charset=utf-8", headers={"Cache-Control": "no-store"})
