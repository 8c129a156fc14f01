import pytest
from tests.corpus import generate_columnar, generate_excel, generate_lvm, generate_matlab, generate_tdms

GENERATORS = (generate_tdms, generate_lvm, generate_matlab, generate_excel, generate_columnar)


@pytest.fixture(scope="session")
def lab_files(tmp_path_factory):
    """Folder "read" with files that are read, and "damaged" with files that are refused."""
    folder = tmp_path_factory.mktemp("lab_files")
    for name in ("read", "damaged"):
        (folder / name).mkdir()
    for generator in GENERATORS:
        generator.good(folder / "read")
        generator.damaged(folder / "damaged", folder / "read")
    return folder
