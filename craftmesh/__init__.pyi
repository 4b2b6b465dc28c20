"""Public names for type checkers, editors and `craftmesh.__init__`, which imports each at its first use."""

from craftmesh.assembly.assemble import assemble as assemble
from craftmesh.assembly.open_crack import open_crack as open_crack
from craftmesh.commands.check import check as check
from craftmesh.cracks.options import CrackOptions as CrackOptions
from craftmesh.cracks.prepare import prepare_crack as prepare_crack
from craftmesh.cracks.series import prescribed_crack as prescribed_crack
from craftmesh.cracks.triangulated import crack_from_triangles as crack_from_triangles
from craftmesh.deck.write_deck import DeckOptions as DeckOptions
from craftmesh.deck.write_deck import write_deck as write_deck
from craftmesh.errors import CraftmeshError as CraftmeshError
from craftmesh.gradation.gradate import GradateOptions as GradateOptions
from craftmesh.gradation.gradate import gradate as gradate
from craftmesh.insertion.insert import insert_crack as insert_crack
from craftmesh.insertion.options import InsertOptions as InsertOptions
from craftmesh.io.surface_files import read_grain_folder as read_grain_folder
from craftmesh.io.vtk import read_crack as read_crack
from craftmesh.io.vtk import read_surface as read_surface
from craftmesh.io.vtk import read_tets as read_tets
from craftmesh.remeshing.remesh import RemeshOptions as RemeshOptions
from craftmesh.remeshing.remesh import remesh as remesh
from craftmesh.sizing.sizing import Sizing as Sizing
from craftmesh.sizing.sizing import SizingOptions as SizingOptions
from craftmesh.sizing.sizing import sizing_for as sizing_for
from craftmesh.sizing.sources import Defects as Defects
from craftmesh.sizing.sources import sizing_around as sizing_around
from craftmesh.stitching.stitch import stitch_grains as stitch_grains
from craftmesh.surface.check_surface import check_surface as check_surface
from craftmesh.tetrahedra.options import TetrahedralizeOptions as TetrahedralizeOptions
from craftmesh.tetrahedra.tetrahedralize import tetrahedralize as tetrahedralize
from craftmesh.tetrahedra.volume import Volume as Volume
from craftmesh.tetrahedra.volume import mesh_volume as mesh_volume
from craftmesh.types import Crack as Crack
from craftmesh.types import Surface as Surface
from craftmesh.types import TetMesh as TetMesh
from craftmesh.types import Voxels as Voxels
from craftmesh.voxels.clean import clean as clean
from craftmesh.voxels.islands import find_islands as find_islands
from craftmesh.voxels.options import CleanOptions as CleanOptions
from craftmesh.voxels.reading import ReadOptions as ReadOptions
from craftmesh.voxels.reading import read_voxels as read_voxels

__version__: str
