"""Random bytes and mutated frames into the firmware's parser and application, and into the host's parser.

The firmware's C is compiled for this machine with the address and undefined-behaviour sanitizers, errors fatal
(firmware_under_fire.c in tests/extras/board/fuzz). Two streams: random bytes with a valid ARM and DRIVE now and then,
so that there is a run to disturb; and frames that were valid once: bits flipped, bytes lost, doubled, inserted, cut, or
a payload of odd numbers with a right check sum. After every byte and tick the output must be safe: finite, 0 V to the
maximum, 0 V when off, gone 0.25 s after the last command. The host's parser gets the same bytes cut anywhere and must
accept and reject exactly as many frames. Exit 1 where anything differs.

    python benchmarks/fuzz_firmware.py [--quick] [--seed N]     10,000,000 bytes and 1,000,000 frames, or a hundredth
"""

from __future__ import annotations

import importlib.util
import json
import random
import shutil
import struct
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from musclewire.extras.board import (
    MAXIMUM_BODY_BYTES,
    FrameParser,
    MessageKind,
    SerialFrame,
    encode_frame,
    read_message,
)

ROOT = Path(__file__).resolve().parent.parent
BOARD = "mps2-an386"
RANDOM_BYTES, MUTATED_FRAMES, QUICK_DIVISOR = 10_000_000, 1_000_000, 100
CHUNK_BYTES = 1 << 16
SANITIZERS = ["-fsanitize=address,undefined", "-fno-sanitize-recover=all", "-fno-omit-frame-pointer", "-g", "-O1"]
ODD_NUMBERS = [
    *(0.0, -0.0, 0.3, 1.0, 2.0, 3.59999, 3.6, 3.60001, 3.7, -1e-30, 1e-40, 1e38, -1e38, 0.01, 0.03, 0.04, -0.02),
    *(float("nan"), float("inf"), float("-inf")),
]


def compiled(folder: Path) -> Path:
    """Build the firmware and the judge around it for this machine. Raises RuntimeError without a compiler."""
    compiler = shutil.which("clang") or shutil.which("gcc")
    if compiler is None:
        raise RuntimeError("no C compiler: apt-get install --no-install-recommends -y clang (or gcc libc6-dev)")
    spec = importlib.util.spec_from_file_location("firmware_build", ROOT / "firmware" / "build.py")
    assert spec is not None
    assert spec.loader is not None
    build = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = build
    spec.loader.exec_module(build)
    build.write_sources(BOARD, folder)
    harness = ROOT / "tests" / "extras" / "board" / "fuzz" / "firmware_under_fire.c"
    sources = [file for file in sorted((ROOT / "firmware" / "src").glob("*.c")) if file.name != "main.c"]
    sources += [harness, *sorted((folder / "src").glob("*.c"))]
    program = folder / "firmware_under_fire"
    places = [f"-I{ROOT / 'firmware' / 'src'}", f"-I{folder / 'src'}"]
    options = ["-std=c99", "-Wall", "-Wno-unknown-pragmas", "-ffp-contract=off"]
    command = [compiler, *options, *SANITIZERS, *places, *map(str, sources), "-lm", "-o", str(program)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise RuntimeError(f"the firmware does not compile here:\n{done.stderr}")
    return program


def drive(voltage: float) -> bytes:
    return struct.pack("<f", voltage)


def start_of_a_run(chance: random.Random) -> bytes:
    """Return the frames that arm and drive a board, after a zero that ends whatever came before."""
    frames = [
        SerialFrame(MessageKind.STREAM, 1, struct.pack("<H", chance.choice([0, 1, 5, 10]))),
        SerialFrame(MessageKind.ARM, 2, b""),
        SerialFrame(MessageKind.DRIVE, 3, drive(chance.uniform(0.3, 3.6))),
    ]
    if chance.random() < 0.3:
        frames.append(SerialFrame(MessageKind.TARGET, 4, drive(chance.uniform(0.0, 0.03))))
    return b"\0" + b"".join(encode_frame(frame) for frame in frames)


def random_stream(count: int, chance: random.Random) -> Iterator[bytes]:
    """Yield random bytes, ``count`` in total, and a run to disturb between them."""
    left = count
    while left > 0:
        yield start_of_a_run(chance)
        size = min(left, chance.choice([20, 200, 2000, 20000]))
        # Zeros are what ends a frame: with more of them more short frames are tried.
        data = chance.randbytes(size)
        yield data if chance.random() < 0.5 else data.replace(b"\x55", b"\0").replace(b"\xaa", b"\0")
        left -= size


def valid_frame(chance: random.Random) -> SerialFrame:
    """Return a frame with a right check sum and any type, some with numbers that no honest host sends."""
    kind = chance.choice([*range(1, 8), 1, 2, 3, 3, 3, 4, 4, 7, 0x7F, 0x81, 0x82, chance.randrange(256)])
    if kind in (MessageKind.DRIVE, MessageKind.TARGET) and chance.random() < 0.9:
        payload = drive(chance.choice(ODD_NUMBERS))
    elif kind == MessageKind.STREAM and chance.random() < 0.8:
        payload = struct.pack("<H", chance.choice([0, 1, 2, 10, 65535]))
    else:
        payload = chance.randbytes(chance.choice([0, 0, 0, 1, 2, 4, 4, 32, MAXIMUM_BODY_BYTES - 8]))
    return SerialFrame(kind, chance.randrange(1 << 16), payload)


def mutated(line: bytes, chance: random.Random) -> bytes:
    """Return a frame's bytes, damaged once or a few times, or as they are."""
    found = bytearray(line)
    for _ in range(chance.choice([0, 1, 1, 1, 1, 2, 3])):
        at = chance.randrange(len(found)) if found else 0
        what = chance.randrange(6)
        if what == 0 and found:
            found[at] ^= 1 << chance.randrange(8)
        elif what == 1 and found:
            found[at] = chance.randrange(256)
        elif what == 2:
            del found[at]
        elif what == 3:
            found.insert(at, chance.randrange(256))
        elif what == 4:
            del found[at:]
        else:
            found[at:at] = found[at : at + chance.choice([1, 4, 100])]
        if not found:
            break
    return bytes(found)


def mutated_stream(count: int, chance: random.Random) -> Iterator[bytes]:
    """Yield ``count`` mutated frames, and a run to disturb between them."""
    for index in range(count):
        if index % 12 == 0:
            yield start_of_a_run(chance)
        yield mutated(encode_frame(valid_frame(chance)), chance)


def chunks(pieces: Iterator[bytes]) -> Iterator[bytes]:
    """Yield the same bytes in chunks of a size that is quick to hand over."""
    kept = bytearray()
    for piece in pieces:
        kept += piece
        if len(kept) >= CHUNK_BYTES:
            yield bytes(kept)
            kept.clear()
    yield bytes(kept)


def fire(program: Path, pieces: Iterator[bytes], seed: int) -> tuple[dict[str, Any], FrameParser]:
    """Feed both parsers with the same bytes and return what each has counted. Raises RuntimeError if C fails."""
    host, cuts = FrameParser(), random.Random(seed)
    judge = subprocess.Popen(
        [program, str(seed)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE
    )
    assert judge.stdin is not None
    try:
        for chunk in chunks(pieces):
            judge.stdin.write(chunk)
            at = 0
            while at < len(chunk):
                size = cuts.choice([1, 7, 64, 500, 4000])
                for frame in host.feed(chunk[at : at + size]):
                    read_message(frame)
                at += size
    except BrokenPipeError:
        pass  # what it says on its way out comes below
    said, complaint = judge.communicate()
    if judge.returncode != 0:
        raise RuntimeError(f"the firmware failed ({judge.returncode}): {complaint.decode(errors='replace')[:3000]}")
    return json.loads(said), host


def show(name: str, firmware: dict[str, Any], host: FrameParser, wall_s: float) -> bool:
    """Print what came of a stream; return whether firmware and host agree."""
    agree = (firmware["accepted"], firmware["rejected"]) == (host.accepted, host.errors.total)
    print(
        f"{name}: {firmware['bytes']:,} bytes, firmware accepted {firmware['accepted']:,} and rejected "
        f"{firmware['rejected']:,} frames; host {host.accepted:,} and {host.errors.total:,}; "
        f"{'same' if agree else 'DIFFERENT'}"
    )
    print(
        f"  {firmware['runs']:,} runs, {firmware['trips']:,} trips, {firmware['refused_commands']:,} commands refused, "
        f"{firmware['silences']:,} silences, {firmware['ticks']:,} ticks; highest output {firmware['highest_v']:.4f} "
        f"V, never unsafe; {wall_s:.0f} s"
    )
    return agree


def main() -> int:
    divisor = QUICK_DIVISOR if "--quick" in sys.argv else 1
    seed = int(sys.argv[sys.argv.index("--seed") + 1]) if "--seed" in sys.argv else 1
    chance = random.Random(seed)
    agree = True
    with tempfile.TemporaryDirectory() as folder:
        try:
            program = compiled(Path(folder))
            for name, pieces in (
                ("random bytes", random_stream(RANDOM_BYTES // divisor, chance)),
                ("mutated frames", mutated_stream(MUTATED_FRAMES // divisor, chance)),
            ):
                began_s = time.perf_counter()
                firmware, host = fire(program, pieces, seed)
                agree = show(name, firmware, host, time.perf_counter() - began_s) and agree
        except RuntimeError as problem:
            print(problem)
            return 1
    return 0 if agree else 1


if __name__ == "__main__":
    sys.exit(main())
