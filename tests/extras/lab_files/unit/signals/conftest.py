import pytest
from tests.extras.lab_files.corpus.generate_lab_files import generate


@pytest.fixture(scope="session")
def lab_files(tmp_path_factory):
    """Folder "read" with files that are read, and "damaged" with files that are refused."""
    folder = tmp_path_factory.mktemp("lab_files")
    generate(folder)
    return folder
