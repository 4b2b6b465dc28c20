"""TIFF stacks: one file of several pages, or a folder of slices; pages are z, rows y, columns x."""

import os
import re
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np

from craftmesh.errors import CraftmeshError, rounded_values
from craftmesh.extras import extra
from craftmesh.io.file_volume import FileVolume
from craftmesh.io.header_checks import DEFLATE, HEAD, heard, refuse_false_size

SUFFIXES = (".tif", ".tiff")
Place = tuple[np.ndarray | None, str]  # spacing (3,) along x, y, z, None if unknown, and its unit
NO_PLACE: Place = None, ""
# Largest ratio of unpacked to stored size, by the value of the tag Compression; other values: unlimited.
_RATIOS = {1: 1, 8: DEFLATE, 32946: DEFLATE}
# Options of tifffile that read files as plain pages, without other files that their headers name.
_ALONE: dict[str, Any] = dict.fromkeys(("is_ome", "is_mmstack", "is_ndtiff"), False)


def read_tiff(path: str | os.PathLike) -> FileVolume:
    """Read a stack of integer slices: one file, or a folder with slices in the order of their numbers.

    The spacing of a single file is taken from its ImageJ or OME header; otherwise it is None. Raises
    CraftmeshError for damaged files, colours or several channels, and slices that differ in size or type.
    """
    path = Path(path)
    files = slice_files(path) if path.is_dir() else [path]
    slices, places = zip(*[_pages(file) for file in files])
    if len(files) > 1:
        _refuse_unlike(files, slices)
    volume = np.concatenate(slices)
    spacing, unit = places[0] if len(files) == 1 else NO_PLACE
    notes: tuple[str, ...] = ()
    if spacing is not None:
        notes = (f"lengths are in {unit or 'an unknown unit'}, spacing {rounded_values(spacing)}",)
    if volume.dtype == np.uint8 and volume.max(initial=0) == 255:
        notes += ("8-bit labels reach 255, so larger labels may have been clipped; export 16 bits",)
    return FileVolume(volume.transpose(2, 1, 0), spacing, notes=notes)


def slice_files(folder: Path) -> list[Path]:
    """Return the .tif files of a folder in the order of the number in their names, without hidden files.

    Names may differ only in this number, with or without leading zeros, and it must increase by one. Raises
    CraftmeshError that names two files that break this rule.
    """
    visible = (file for file in sorted(folder.iterdir()) if not file.name.startswith("."))
    files = [file for file in visible if file.suffix.lower() in SUFFIXES]
    for file in files:
        if not file.is_file():
            raise CraftmeshError(
                f"{file}: is a folder, broken link, FIFO or device, not a slice; move it to another folder"
            )
    if not files:
        raise CraftmeshError(
            f"{folder}: has no .tif slices; give a folder of slices, or run craftmesh stitch on STL files"
        )
    if len(files) == 1:
        return files
    numbers = _numbers(folder, files)
    in_order = sorted(files, key=lambda file: numbers[file])
    for one, other in pairwise(in_order):
        step = numbers[other] - numbers[one]
        if step != 1:
            fault = f"have {step - 1} missing slices between them" if step else "have the same number"
            raise CraftmeshError(
                f"{folder}: {one.name} and {other.name} {fault}; number the slices without gaps"
            )
    return in_order


def _numbers(folder: Path, files: list[Path]) -> dict[Path, int]:
    """Return the number of each file: the digits between the common start and end of all names."""
    names = [file.stem for file in files]
    start = os.path.commonprefix(names).rstrip("0123456789")
    rests = [name[len(start) :] for name in names]
    end = os.path.commonprefix([rest[::-1] for rest in rests]).rstrip("0123456789")
    between = {file: rest[: len(rest) - len(end)] for file, rest in zip(files, rests)}
    if all(re.fullmatch("[0-9]+", digits) for digits in between.values()):
        return {file: int(digits) for file, digits in between.items()}
    stems = [re.sub("[0-9]+", "#", name) for name in names]
    other = next((file for file, stem in zip(files, stems) if stem != stems[0]), files[-1])
    raise CraftmeshError(
        f"{folder}: {files[0].name} and {other.name} do not differ only in one number; keep the slices of "
        "one stack, and move other files away"
    )


def _pages(file: Path) -> tuple[np.ndarray, Place]:
    """Return the pages (z, y, x) of a file, and their spacing and unit.

    Raises CraftmeshError unless the pages are complete, grey, and of the same size and type.
    """
    with extra("formats"):
        import tifffile

    try:
        with heard("tifffile") as said, tifffile.TiffFile(file, **_ALONE) as tif:
            series = tif.series
            pages: Any
            for pages in series:
                page, there = pages.keyframe, tif.filehandle.size
                ratio = _RATIOS.get(int(page.compression))
                refuse_false_size(file, "pages", pages.shape, pages.dtype.itemsize, there, ratio)
                refuse_false_size(file, "a tile", page.chunks, page.dtype.itemsize, there, ratio)
            kinds = {(pages.shape[-2:], str(pages.dtype)) for pages in series}
            place = _place(file, tif)
            _refuse_colours(file, series[0])
            if len(kinds) > 1 or max(pages.ndim for pages in series) > 3:
                raise CraftmeshError(
                    f"{file}: has pages of {len(kinds)} sizes or types, shape {series[0].shape} (axes "
                    f"{series[0].axes}); expected equal grey pages (z, y, x), save only one channel"
                )
            # Some programs write each page as a series of its own.
            found = np.concatenate([pages.asarray().reshape(-1, *pages.shape[-2:]) for pages in series])
        missed = [fault for fault in said if fault.startswith("<tifffile.TiffPage")]
        if missed:  # tifffile logs a damaged page, and leaves it out or fills it with zeros
            raise ValueError(missed[0])
        return found, place
    except CraftmeshError:
        raise
    except Exception as error:  # tifffile and its decoders raise many types
        reason = " ".join(str(error).split())
        raise CraftmeshError(f"{file}: cannot be read as TIFF ({reason}); export it uncompressed") from None


def _place(file: Path, tif: Any) -> Place:
    """Return spacing and unit from a file's ImageJ or OME header, NO_PLACE if they are not complete.

    Raises CraftmeshError for several channels, and for several times with several slices.
    """
    page = tif.pages.first
    text = page.description
    counts, lengths, units = [1, 1, 1], [], {""}
    if "<OME" in text[:HEAD]:
        pixels = ElementTree.fromstring(text.encode()).find(".//{*}Pixels")
        named = {} if pixels is None else pixels.attrib
        counts = [int(named.get(f"Size{axis}", 1)) for axis in "CTZ"]
        lengths = [float(named.get(f"PhysicalSize{axis}", 0)) for axis in "XYZ"]
        units = {named.get(f"PhysicalSize{axis}Unit", "µm") for axis in "XYZ"}
    elif tif.is_imagej:
        named = tif.imagej_metadata
        counts = [int(named.get(key, 1)) for key in ("channels", "frames", "slices")]
        units = {str(named.get(key, named.get("unit", ""))) for key in ("unit", "yunit", "zunit")}
        if "spacing" in named or units - {"", "pixel", "pixels"}:  # ImageJ omits spacing 1
            lengths = [*(1 / each if each else 0 for each in page.resolution), named.get("spacing", 1.0)]
    if counts[0] > 1 or counts[1] > 1 < counts[2]:
        raise CraftmeshError(
            f"{file}: has {counts[0]} channels, {counts[1]} times, {counts[2]} slices; expected one label "
            "per pixel, save only the channel of the labels (ImageJ: Image > Duplicate)"
        )
    is_known = len(units) == 1 and lengths and min(lengths) > 0 and np.isfinite(lengths).all()
    return (np.array(lengths), units.pop().replace(r"\u00B5", "µ")) if is_known else NO_PLACE


def _refuse_colours(file: Path, pages: Any) -> None:
    """Raise CraftmeshError for pages of several values per pixel, unless the file's tags call them grey.

    Grey pages with several values per pixel are narrow stacks, whose slices tifffile took for channels.
    """
    page = pages.keyframe
    if page.samplesperpixel > 1 and (page.photometric > 1 or any(page.extrasamples)):
        raise CraftmeshError(
            f"{file}: is a colour image (photometric {page.photometric.name}, {page.samplesperpixel} "
            f"values per pixel, shape {pages.shape}); expected one label per pixel; if it is a stack 3 or "
            "4 pixels wide, write it as grey: tifffile needs photometric='minisblack' for this"
        )


def _refuse_unlike(files: list[Path], slices: Sequence[np.ndarray]) -> None:
    for file, pages in zip(files, slices):
        if len(pages) > 1:
            raise CraftmeshError(
                f"{file}: has {len(pages)} pages, but the folder has {len(files) - 1} other .tif files; "
                "keep one slice per file, or only one stack in the folder"
            )
        if (pages.shape, pages.dtype) != (slices[0].shape, slices[0].dtype):
            first, this = (f"{s.shape[1:]} {s.dtype}" for s in (slices[0], pages))
            raise CraftmeshError(
                f"{file.parent}: slices differ: {files[0].name} has {first}, {file.name} has {this}; "
                "export all slices with one shape and type"
            )
