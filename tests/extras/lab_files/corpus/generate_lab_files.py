"""Write the corpus's files of LabVIEW, MATLAB, Excel, HDF5 and Parquet with the libraries that write them.

    python -m tests.extras.lab_files.corpus.generate_lab_files

``lab_files.toml`` says what is expected of each. Files are committed, so that another version of a library that writes
them otherwise does not change what is tested.
"""

from __future__ import annotations

from pathlib import Path

from tests.extras.lab_files.corpus import (
    generate_columnar,
    generate_excel,
    generate_lvm,
    generate_matlab,
    generate_tdms,
)

GENERATORS = (generate_tdms, generate_lvm, generate_matlab, generate_excel, generate_columnar)


def generate(folder: Path) -> None:
    """Write all files to the folders "read" and "damaged" of a folder."""
    for name in ("read", "damaged"):
        (folder / name).mkdir(exist_ok=True)
    for generator in GENERATORS:
        generator.good(folder / "read")
        generator.damaged(folder / "damaged", folder / "read")


if __name__ == "__main__":
    generate(Path(__file__).parent)
