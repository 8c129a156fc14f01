import pytest
from tests.places import TESTS


@pytest.fixture(scope="session")
def lab_files():
    """Folder "read" with files that are read, and "damaged" with files that are refused."""
    return TESTS / "extras/lab_files/corpus"
