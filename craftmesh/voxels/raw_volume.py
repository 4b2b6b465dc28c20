"""A volume as its file gives it, before cleaning: 0 may still mean "not indexed"."""

from dataclasses import dataclass, field

import numpy as np

from craftmesh.errors import CraftmeshError
from craftmesh.types import Voxels


@dataclass(frozen=True)
class RawVolume:
    """Voxels plus what only their file knows.

    voxels: labels > 0 grains, -k the declared void k, 0 background. unindexed (nx, ny, nz) bool: voxels of
    material whose grain is not known, their label is 0. remap: label in the file -> label in `voxels`, for
    every label that occurs, sorted. notes: sentences for the report. background: what label 0 is taken for
    where its file does not say it, else empty.
    """

    voxels: Voxels
    unindexed: np.ndarray
    remap: dict[int, int] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    background: str = ""

    def __post_init__(self) -> None:
        if self.unindexed.shape != self.voxels.labels.shape or self.unindexed.dtype != bool:
            raise CraftmeshError(
                f"RawVolume.unindexed is {self.unindexed.dtype} {self.unindexed.shape}; "
                f"expected bool {self.voxels.labels.shape}"
            )


def as_raw(voxels: Voxels) -> RawVolume:
    """Return voxels that are all indexed as a RawVolume, their labels kept."""
    labels = np.unique(voxels.labels).tolist()
    return RawVolume(voxels, np.zeros(voxels.labels.shape, bool), dict(zip(labels, labels)))
