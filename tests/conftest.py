"""Fixtures that all tests share."""

from collections import Counter
from pathlib import Path

import pytest
from hypothesis import settings

ROOT = Path(__file__).resolve().parents[1]

# no time limit for an example: machines are shared, and a first call may compile a kernel
settings.register_profile("craftmesh", deadline=None)
settings.load_profile("craftmesh")


@pytest.hookimpl(tryfirst=True)  # before those that are not asked for are left out
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Put the campaigns first, and mark the rows of a sampled table slow, but every n-th.

    Each campaign is a long chain for one worker; the other runs the rest beside it.
    """
    items.sort(key=lambda item: ROOT / "tests" / "workflow" not in item.path.parents)
    rows: Counter[str] = Counter()
    for item in items:
        if sampled := item.get_closest_marker("sampled"):
            table = item.nodeid.partition("[")[0]
            if rows[table] % sampled.args[0]:
                item.add_marker(pytest.mark.slow)
            rows[table] += 1


@pytest.fixture(scope="session")
def shared_data() -> Path:
    """The folder of real microstructures beside the project; tests that need it skip without it."""
    folder = ROOT.parent / "shared" / "data"
    if not folder.is_dir():
        pytest.skip("real microstructures (../shared/data) are not on this machine")
    return folder
