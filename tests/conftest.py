"""Fixtures that all tests share."""

from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Put the campaigns first: each is a long chain for one worker; the other runs the rest beside it."""
    items.sort(key=lambda item: ROOT / "tests" / "workflow" not in item.path.parents)


@pytest.fixture(scope="session")
def shared_data() -> Path:
    """The folder of real microstructures beside the project; tests that need it skip without it."""
    folder = ROOT.parent / "shared" / "data"
    if not folder.is_dir():
        pytest.skip("real microstructures (../shared/data) are not on this machine")
    return folder
