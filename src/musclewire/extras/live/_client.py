"""A client for programs: the state of a bench, its rows, and control of it, over HTTP."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from types import TracebackType
from typing import Any

import httpx
import numpy as np

from musclewire.arrays import FloatArray
from musclewire.errors import CallerError, RigError
from musclewire.extras.live._server.access import is_loopback, own_token
from musclewire.extras.live._silence import PING_S

POLL_S = 0.05
LEASE_HEADER = "Musclewire-Lease"


class LiveClient:
    """A program's connection to one bench of a running ``musclewire serve``.

    Anybody may read and stop; commands need control, which one person or program has at a time: see :meth:`control`.
    While a program has control, a thread of the client shows the server every 0.15 s that it is there. If the program
    ends or its machine is lost, a heated run ends within a second and the rig goes to its sense voltage.

    Parameters
    ----------
    address
        Address that ``musclewire serve`` printed; the default is that of a server on this machine.
    token
        Token of the server; None to take it from the address, if it is there after ``?token=``, else on this machine
        that of the user.
    bench
        Name of the bench; None for the only one.
    timeout_s
        Time [s] to wait for an answer, longer than any bench takes to begin a command.

    Raises
    ------
    CallerError
        If no server answers there, the token is not its own, or there is no such bench.

    Examples
    --------
    With ``musclewire serve`` running on this machine::

        with mw.LiveClient() as client, client.control("my program"):
            client.command("switch_on")
            client.wait_for("ready")
    """

    def __init__(
        self,
        address: str = "http://127.0.0.1:8765",
        *,
        token: str | None = None,
        bench: str | None = None,
        timeout_s: float = 65.0,
    ) -> None:
        """Connect, and find the bench."""
        url = httpx.URL(address)
        token = token or url.params.get("token") or (own_token() if is_loopback(url.host) else None)
        headers = {} if token is None else {"Authorization": f"Bearer {token}"}
        base = url.copy_with(query=None, path="/api/v1/")
        # No proxies of the environment: the rig is on this machine or in this network.
        self._http = httpx.Client(base_url=base, headers=headers, timeout=timeout_s, trust_env=False)
        self._cursor, self._lease = -1, _Lease()
        try:
            self.bench = self._chosen(bench)
        except BaseException:
            self._http.close()
            raise

    def __enter__(self) -> LiveClient:
        """Return the client."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Give control up, if this program has it, and close the connection."""
        self.close()

    def close(self) -> None:
        """Give control up, if this program has it, and close the connection."""
        self._give_up()
        self._http.close()

    def _chosen(self, bench: str | None) -> str:
        names = [one["bench"] for one in self._get("benches")["benches"]]
        if bench is None and len(names) != 1:
            raise CallerError(f"the server has several benches ({', '.join(names)}): name one as bench")
        if bench is not None and bench not in names:
            raise CallerError(f"the server has no bench '{bench}'; it has {', '.join(names)}")
        return bench or str(names[0])

    # What anybody may

    def state(self) -> dict[str, Any]:
        """Return the state of the bench, as the reference of the live API lists it."""
        state: dict[str, Any] = self._get(f"benches/{self.bench}")
        return state

    def rows(self) -> dict[str, FloatArray]:
        """Return the rows that have come since the last call.

        Returns
        -------
        Columns in SI units by name, each of shape (n_rows,), at most 100 rows a second; those of the latest layout if
        the columns have changed in between. Empty at the first call: from then on rows are counted.
        """
        answer = self._get(f"benches/{self.bench}/rows", {"after": self._cursor})
        self._cursor = answer["cursor"]
        if not answer["parts"]:
            return {}
        columns = answer["parts"][-1]["columns"]
        parts = [np.array(one["rows"], float) for one in answer["parts"] if one["columns"] == columns]
        return dict(zip(columns, np.vstack(parts).T, strict=True))

    def stop(self) -> str:
        """Switch the drive off at once; needs no control.

        Returns
        -------
        The phase of the bench once its drive is off: "stopped", or "failed" if its process has ended.

        Raises
        ------
        RigError
            If the server does not confirm within 1 s that the drive is off: use the rig's own switch.
        """
        answer = self._http.post(f"benches/{self.bench}/stop")
        phase = str(answer.json().get("phase", ""))
        if answer.status_code != httpx.codes.OK:
            raise RigError(
                f"the server has not confirmed that the drive is off ({phase or answer.text}): switch it off"
            )
        return phase

    def recordings(self) -> list[str]:
        """Return the names of the recordings in the session's folder, the newest first."""
        return [str(one["name"]) for one in self._get("recordings")["recordings"]]

    def download(self, name: str, path: str | Path) -> Path:
        """Download a recording.

        Parameters
        ----------
        name
            One of :meth:`recordings`.
        path
            File to write; one that exists is replaced.

        Returns
        -------
        The file.

        Raises
        ------
        CallerError
            If the session has no recording of that name.
        """
        target = Path(path)
        with self._http.stream("GET", f"recordings/{name}") as answer:
            if answer.is_error:
                answer.read()
                _refuse(answer)
            with target.open("wb") as file:
                for portion in answer.iter_bytes():
                    file.write(portion)
        return target

    def wait_for(self, *phases: str, timeout_s: float = 60.0) -> dict[str, Any]:
        """Wait until the bench is in a phase.

        Parameters
        ----------
        *phases
            Phases, as in ``state()["phase"]``: "ready", "busy", "off", "stopped", "failed".
        timeout_s
            Time [s] to wait at most.

        Returns
        -------
        The state in which it is.

        Raises
        ------
        RigError
            If it is stopped or has failed and that was not waited for, or after the time.
        """
        ends_s = time.monotonic() + timeout_s
        while (state := self.state())["phase"] not in phases:
            if state["phase"] in ("stopped", "failed"):
                raise RigError(f"the bench is {state['phase']}: {state['why']}")
            if time.monotonic() > ends_s:
                raise RigError(f"the bench is {state['phase']} after {timeout_s:g} s, and not {' or '.join(phases)}")
            time.sleep(POLL_S)
        return state

    # What needs control

    @contextmanager
    def control(self, name: str = "a program", *, timeout_s: float = 30.0) -> Iterator[LiveClient]:
        """Have control of the bench inside a ``with`` block; at its end a heated run ends.

        Parameters
        ----------
        name
            What others see as the holder's name.
        timeout_s
            Time [s] for which a present holder may take to give control up, at most.

        Returns
        -------
        The client.

        Raises
        ------
        RigError
            If the holder does not give control up in time.
        """
        answer = self._send("POST", "control", {"name": name})
        self._lease.begin(str(answer["lease"]), self._sign_of_life)
        try:
            self._wait_for_control(answer, timeout_s)
            yield self
        finally:
            self._give_up()

    def command(self, do: str, **fields: Any) -> None:
        """Send a command; returns when the bench has begun it.

        Parameters
        ----------
        do
            Name of the command, such as "switch_on" or "target".
        **fields
            Its fields, as the reference of the live API lists them.

        Raises
        ------
        CallerError
            If the bench refuses the command, or it makes no sense.
        RigError
            If this program does not have control, or has lost it.
        """
        if do != "stop" and self._lease.ended_why:
            raise RigError(self._lease.ended_why)
        self._send("POST", "commands", {"do": do, **fields})

    def keep_or_give(self, *, give: bool) -> None:
        """Answer somebody who asks for control, which the state of :meth:`asked_by` shows.

        Parameters
        ----------
        give
            True to give it; this program then has control no longer.
        """
        self._send("PUT", "control", {"give": give})

    def asked_by(self) -> str | None:
        """Return the name of who asks for control; None if nobody does."""
        asked: str | None = self._send("PUT", "control", {})["asked_by"]
        return asked

    def _wait_for_control(self, answer: Mapping[str, Any], timeout_s: float) -> None:
        ends_s = time.monotonic() + timeout_s
        while not answer["yours"]:
            if time.monotonic() > ends_s:
                raise RigError(
                    f"{answer['holder']} has control of {self.bench} and has not given it up: ask for it, or wait "
                    "longer (timeout_s)"
                )
            time.sleep(POLL_S)
            answer = self._send("PUT", "control", {})

    def _sign_of_life(self) -> bool:
        return bool(self._send("PUT", "control", {})["holder"])

    def _give_up(self) -> None:
        if self._lease.end():
            with _ignored():
                self._send("DELETE", "control", None)
            self._lease = _Lease()

    def _get(self, path: str, parameters: Mapping[str, Any] | None = None) -> Any:
        return self._answer("GET", path, params=parameters)

    def _send(self, method: str, what: str, body: Mapping[str, Any] | None) -> Any:
        headers = {LEASE_HEADER: self._lease.key} if self._lease.key else {}
        return self._answer(method, f"benches/{self.bench}/{what}", json=body, headers=headers)

    def _answer(self, method: str, path: str, **how: Any) -> Any:
        try:
            answer = self._http.request(method, path, **how)
        except httpx.TransportError as error:
            server = self._http.base_url.copy_with(path="/")
            raise CallerError(f"no answer from {server} ({error}): is 'musclewire serve' running there?") from None
        if answer.is_error:
            _refuse(answer)
        return answer.json()


def _refuse(answer: httpx.Response) -> None:
    """Raise what an answer says is wrong: RigError without control, CallerError otherwise."""
    try:
        content = answer.json()
        problem = content.get("problem") or content.get("message") or answer.text
    except ValueError:
        problem = answer.text
    kind = RigError if answer.status_code == httpx.codes.FORBIDDEN else CallerError
    raise kind(f"the server answers: {problem}")


@contextmanager
def _ignored() -> Iterator[None]:
    """Ignore that a lease has already ended, or that the server has."""
    try:
        yield
    except (CallerError, RigError):
        return


class _Lease:
    """A lease of this program, and the thread that shows that it is there."""

    def __init__(self) -> None:
        """Begin with none."""
        self.key, self.ended_why = "", "take control first: with client.control(): ..."
        self._ending = threading.Event()
        self._thread: threading.Thread | None = None

    def begin(self, key: str, sign_of_life: Callable[[], bool]) -> None:
        """Take the key of a lease and keep it alive."""
        self.key, self.ended_why = key, ""
        self._thread = threading.Thread(target=self._run, args=(sign_of_life,), name="musclewire lease", daemon=True)
        self._thread.start()

    def _run(self, sign_of_life: Callable[[], bool]) -> None:
        while not self._ending.wait(PING_S):
            try:
                sign_of_life()
            except (CallerError, RigError) as error:
                self.ended_why = f"control was lost: {error}"
                return

    def end(self) -> bool:
        """End the thread; return whether there was a lease."""
        self._ending.set()
        if self._thread is not None:
            self._thread.join()
        return bool(self.key)
