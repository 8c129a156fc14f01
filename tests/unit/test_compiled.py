from __future__ import annotations

import re
from collections.abc import Iterator
from importlib.machinery import ModuleSpec
from pathlib import Path

import pytest
from numba.core import config

from musclewire import compiled as module
from musclewire.compiled import (
    FILES_WITH_KERNELS,
    ROOMS_WITH_KERNELS,
    Compilation,
    cache_folder,
    compiled,
    compiled_inline,
    compiled_inner,
    kernel_source_hash,
    part_of,
    part_source_hash,
)
from musclewire.manifest import Manifest, manifests

PACKAGE = Path(module.__file__).parent


@pytest.fixture(autouse=True)
def _forget_folders() -> Iterator[None]:
    """Both answers are remembered for the life of a process; here each test asks afresh."""
    for remembered in (cache_folder, kernel_source_hash, part_source_hash):
        remembered.cache_clear()
    yield
    for remembered in (cache_folder, kernel_source_hash, part_source_hash):
        remembered.cache_clear()


def test_a_process_says_once_that_it_compiles_and_counts_for_how_long(caplog: pytest.LogCaptureFixture) -> None:
    compilation = Compilation()
    with caplog.at_level("INFO", "musclewire.compiled"):
        for _ in range(2):
            compilation.on_start(None)
            compilation.on_start(None)  # a kernel that the first one calls
            compilation.on_end(None)
            before_s = compilation.total_s
            compilation.on_end(None)
            assert compilation.total_s > before_s
    (message,) = caplog.messages
    assert message.startswith("compiling wire and controllers to machine code, ")


def doubled_plus_one(x: float) -> float:
    return 2.0 * x + 1.0


def plus(x: float, whole: int) -> float:
    return x + whole


@pytest.mark.skipif(config.DISABLE_JIT, reason="without compilation there is nothing to count")
def test_an_inner_function_is_compiled_once_whatever_constants_its_callers_name(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(module, "cache_root", lambda: tmp_path)
    inner = compiled_inner(plus)

    def calls_it(x: float) -> float:
        return inner(inner(x, 1), 2)

    assert compiled(calls_it)(3.0) == 6.0
    assert len(inner.signatures) == 1  # type: ignore[attr-defined]


def test_the_folder_is_named_by_the_hash_of_the_sources(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(module, "cache_root", lambda: tmp_path)
    monkeypatch.setattr(module, "kernel_source_hash", lambda: "before")
    first = cache_folder()
    cache_folder.cache_clear()
    monkeypatch.setattr(module, "kernel_source_hash", lambda: "after")
    second = cache_folder()
    assert (first, second) == (str(tmp_path / "before"), str(tmp_path / "after"))
    assert Path(str(second)).is_dir()


def package_with_empty_kernels(folder: Path) -> Path:
    """Return a package that has the files with kernels and nothing in them."""
    for name in FILES_WITH_KERNELS:
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text("", "utf-8")
    return folder / "compiled.py"


@pytest.mark.parametrize("name", FILES_WITH_KERNELS)
def test_an_edit_of_any_file_with_kernels_changes_the_hash(
    name: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(module, "__file__", str(package_with_empty_kernels(tmp_path)))
    kernel_source_hash.cache_clear()
    before = kernel_source_hash()
    (tmp_path / name).write_text("x = 1\n", "utf-8")
    kernel_source_hash.cache_clear()
    assert kernel_source_hash() != before


@pytest.mark.parametrize("room", ROOMS_WITH_KERNELS)
def test_an_edit_in_any_room_with_kernels_changes_the_hash(
    room: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """Numba itself would miss the edit of a function that another file's function calls."""
    monkeypatch.setattr(module, "__file__", str(package_with_empty_kernels(tmp_path)))
    source = tmp_path / room / "deeper" / "helper.py"
    source.parent.mkdir(parents=True)
    hashes = []
    for text in ("x = 1\n", "x = 2\n"):
        source.write_text(text, "utf-8")
        kernel_source_hash.cache_clear()
        hashes.append(kernel_source_hash())
    source.rename(source.with_name("renamed.py"))
    kernel_source_hash.cache_clear()
    hashes.append(kernel_source_hash())
    assert len(set(hashes)) == 3


def test_no_other_room_holds_compiled_code() -> None:
    """A kernel outside what the hash covers could go stale unseen."""
    users = {
        path.relative_to(PACKAGE).as_posix()
        for path in PACKAGE.rglob("*.py")
        if re.search(r"from musclewire\.compiled import .*\bcompiled(_inline|_inner)?\b", path.read_text("utf-8"))
    }
    covered = tuple(f"{room}/" for room in ROOMS_WITH_KERNELS)
    of_parts = {
        f"{name.removeprefix('musclewire.').replace('.', '/')}.py" for each in manifests() for name in each.kernels
    }
    assert not [name for name in users - of_parts if not name.startswith(covered) and name not in FILES_WITH_KERNELS]


def test_the_kernels_of_a_part_have_a_folder_of_their_own(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """So an edit of a part, or its absence, leaves the core's cache alone; an edit of the core starts both anew."""
    kernel = tmp_path / "kernel.py"
    kernel.write_text("x = 1\n", "utf-8")
    monkeypatch.setattr(module, "manifests", lambda: (Manifest("robots", kernels=("robots.kernel",)),))
    monkeypatch.setattr(module, "find_spec", lambda _: ModuleSpec("robots.kernel", None, origin=str(kernel)))
    monkeypatch.setattr(module, "cache_root", lambda: tmp_path / "cache")
    core, part = cache_folder(), cache_folder(part_of("robots.kernel"))
    assert (part_of("robots.kernel"), part_of("musclewire.wire._step")) == ("robots", None)
    assert core != part
    part_source_hash.cache_clear()
    cache_folder.cache_clear()
    kernel.write_text("x = 2\n", "utf-8")
    assert cache_folder() == core
    assert cache_folder("robots") != part
    part_source_hash.cache_clear()
    cache_folder.cache_clear()
    changed = cache_folder("robots")
    part_source_hash.cache_clear()
    cache_folder.cache_clear()
    monkeypatch.setattr(module, "kernel_source_hash", lambda: "another core")
    assert cache_folder("robots") != changed


def test_where_nothing_can_be_written_compiling_still_works(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    blocked = tmp_path / "a file, not a folder"
    blocked.write_text("", "utf-8")
    monkeypatch.setattr(module, "cache_root", lambda: blocked)
    assert cache_folder() is None
    assert compiled(doubled_plus_one)(3.0) == 7.0


def test_with_a_folder_the_machine_code_is_kept_there(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(module, "cache_root", lambda: tmp_path)
    before = config.CACHE_DIR
    assert compiled(doubled_plus_one)(3.0) == 7.0
    assert list((tmp_path / kernel_source_hash()).rglob("*.nbi")), "no index of cached code was written"
    assert before == config.CACHE_DIR, "the setting of Numba is not ours to keep"


def test_numbas_own_setting_moves_the_cache(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(config, "CACHE_DIR", str(tmp_path / "mine"))
    assert module.cache_root() == tmp_path / "mine"


def test_without_that_setting_the_cache_is_the_users(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(config, "CACHE_DIR", "")
    monkeypatch.setattr(module.sys, "platform", "linux")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert module.cache_root() == tmp_path / "musclewire" / "kernels"
    monkeypatch.setattr(module.sys, "platform", "win32")
    monkeypatch.setenv("LOCALAPPDATA", str(tmp_path / "local"))
    assert module.cache_root() == tmp_path / "local" / "musclewire" / "kernels"


def test_an_inlined_function_gives_the_same_number_to_its_compiled_caller() -> None:
    inner = compiled_inline(doubled_plus_one)

    def outer(x: float) -> float:
        return inner(x) * inner(x)

    assert compiled(outer)(3.0) == outer(3.0) == 49.0
