"""The command line's door: who is to blame decides the exit code, and an interrupted rig is already safe.

0 done; 1 done, and the result does not hold; 2 wrong usage or wrong input, nothing written; 3 a rig fault, rig
made safe; 130 and 143 interrupted by Ctrl-C and SIGTERM, rig made safe.
"""

from __future__ import annotations

import os
import re
import sys
from typing import Annotated, Any

import typer

from musclewire.app._command_line import CommandLine
from musclewire.app._output import emit_json, in_options, say, show
from musclewire.app._stopping import STOPPED, StoppedCommand, ignore_signals, listen_for_signals
from musclewire.errors import CallerError, MusclewireError
from musclewire.manifest import absent_part

# Typer carries its own copy of click since 0.26; this finds the base of all usage errors in either.
UsageProblem: Any = typer.BadParameter.__mro__[2]


app = typer.Typer(
    name="musclewire",
    cls=CommandLine,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)


@app.callback(invoke_without_command=True)
def options(
    context: typer.Context,
    version: Annotated[
        bool, typer.Option("--version", help="Print the version, and what a report of a bug needs.")
    ] = False,
    json: Annotated[bool, typer.Option("--json", help="With --version: print it as one JSON document.")] = False,
) -> None:
    """Position a shape-memory-alloy wire by its own electrical resistance, without a sensor."""
    if version:
        from musclewire.app._installation import installation, installation_text

        found = installation()
        emit_json(found) if json else show(installation_text(found))
        raise typer.Exit
    if json:
        raise CallerError(
            "--json before a command needs --version; for a command's document, write 'musclewire COMMAND ... --json'"
        )
    if context.invoked_subcommand is None:
        raise CallerError("no command was given: 'musclewire --help' lists them, give one")


def main() -> None:
    """Run the command line and end the process with the documented exit code."""
    listen_for_signals()
    code = run()
    ignore_signals()
    sys.exit(code)


def run(arguments: list[str] | None = None) -> int:
    """Run one command and return its exit code; errors become one line on stderr, one of stdout itself among them."""
    try:
        code = ended(arguments)
        sys.stdout.flush()
        return code
    except OSError as error:
        return report_output(error)


def ended(arguments: list[str] | None) -> int:
    """Run one command and return its exit code; what is wrong is said in one line."""
    try:
        result = app(arguments, standalone_mode=False, prog_name="musclewire")
        return result if isinstance(result, int) else 0
    except MusclewireError as error:
        return report_error(error)
    except SystemExit as stop:
        code = stop.code if isinstance(stop.code, int) else 1
        return report_stop(stop, code) if code in STOPPED else code
    except typer.Exit as done:
        return int(done.exit_code)
    except UsageProblem as error:
        if error.format_message():  # without arguments the help has been shown and nothing is left to say
            say(f"musclewire: {usage_line(error)}")
        return 2


# What a value outside an option's range, or of another kind, is answered with by the library that checks it.
INVALID = r"Invalid value for '(--?[\w-]+)[^']*': Input should be "
IN_OUR_WORDS = (
    (INVALID + r"greater than or equal to (\S+?)\.?$", r"\1: give at least \2"),
    (INVALID + r"less than or equal to (\S+?)\.?$", r"\1: give at most \2"),
    (INVALID + r"a valid integer.*$", r"\1: give a whole number"),
    (INVALID + r"a valid number.*$", r"\1: give a number without a unit"),
)


def usage_line(error: Any) -> str:
    """Return what is wrong with a command line, and where the right words are listed unless a near one was named."""
    message, context = str(error.format_message()), error.ctx
    for words, ours in IN_OUR_WORDS:
        message = re.sub(words, ours, message)
    absent = absent_part("options", f"{getattr(context, 'info_name', '')} {getattr(error, 'option_name', '')}")
    if absent is not None:
        return str(absent)
    near = "Did you mean" in message or "Possible" in message
    if context is None or near or not message.startswith("No such"):
        return message
    return f"{message.rstrip('.')}; '{context.command_path} --help' lists what there is"


def report_error(error: MusclewireError) -> int:
    """Print an error as one line, and where its samples are if a run was being recorded."""
    say(f"musclewire: {' '.join(in_options(str(error)).split())}")
    say_where_samples_are(error)
    return error.exit_code


def report_stop(stop: BaseException, code: int) -> int:
    """Say that a run was stopped, what is left of it or that the rig is safe, and where the recording is."""
    rest = stop.rest if isinstance(stop, StoppedCommand) else "the rig is safe"
    say(f"musclewire: stopped by {STOPPED[code]}; {rest}")
    say_where_samples_are(stop)
    return code


def report_output(error: OSError) -> int:
    """Say that stdout takes no more, but for a reader who has left, and return the exit code; others are raised."""
    try:
        print(flush=True)  # what could not be written is no longer in the buffer
    except OSError:
        # The interpreter flushes once more at its end, and would write a traceback.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        if not isinstance(error, BrokenPipeError):
            say(f"musclewire: the result cannot be written to stdout: {error.strerror}; make room, or write elsewhere")
        return 1
    raise error


def say_where_samples_are(error: BaseException) -> None:
    """Repeat the recorder's note on an exception for a reader who has files and no Python."""
    for note in getattr(error, "__notes__", ()):
        _, separator, path = note.partition(" and in ")
        if separator:
            say(f"musclewire: {note.split(' were recorded')[0]} are in {path}")
