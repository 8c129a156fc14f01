"""Build the documentation site: python docs/build.py [--output FOLDER]

Lays out the pages of docs/ and the project's own pages for Sphinx (docs/site/), writes those that follow from the code
and one for every public name, runs the notebooks, and fails if there is a warning. The site needs no network: open
build/docs/index.html.
"""

from __future__ import annotations

import argparse
import shutil
import sys
from importlib.util import find_spec
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "docs" / "site"))


def main() -> int:
    """Lay out the sources, build, and return Sphinx's exit code."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--output", type=Path, default=ROOT / "build" / "docs", help="folder of the site")
    output = parser.parse_args().output.resolve()
    if find_spec("sphinx") is None or find_spec("myst_nb") is None:
        print(
            'The site is built by Sphinx: pip install ".[docs]" ./packages/design ./studies/robustness in the checkout.'
        )
        return 2
    from api_pages import write_api_pages
    from completeness import missing
    from layout import lay_out
    from sphinx.cmd.build import build_main
    from written_pages import all_written

    sources = output.with_name(output.name + "-sources")
    for folder in (sources, output):
        shutil.rmtree(folder, ignore_errors=True)
    lay_out(ROOT, sources, all_written())
    write_api_pages(sources / "reference")
    words = ["-W", "--keep-going", "-q", "-j", "auto", "-c", str(ROOT / "docs" / "site")]
    code = build_main([*words, "-d", str(sources / "_build"), str(sources), str(output)])
    if code:
        return int(code)
    lines = list(missing(output))
    print(*lines, sep="\n", end="\n" if lines else "")
    print(f"{sum(1 for _ in output.rglob('*.html'))} pages, 0 warnings, {len(lines)} missing: {output / 'index.html'}")
    return 1 if lines else 0


if __name__ == "__main__":
    sys.exit(main())
