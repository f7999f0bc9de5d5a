"""Real matrices of a MATLAB file of version 5 to 7.2.

`scipy.io.loadmat` ends the process with a segmentation fault on some damaged files (scipy 1.10), so that a record which
was cut off or changed could not be refused. This reader takes full real matrices alone and checks every length.

References
----------
.. [1] MAT-File Format, The MathWorks, sections on Level 5 MAT-files.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator
from math import prod
from typing import NamedTuple

import numpy as np

from wroll_fem.typing import FloatArray

HEADER = 128
"""Bytes before the first element."""

MATRIX, COMPRESSED = 14, 15
"""Types of the elements of a file."""

NUMBERS = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 9: "f8", 12: "i8", 13: "u8"}
"""Type of the numbers of an element -> numpy's."""

NUMERIC = range(6, 16)
"""Classes of full matrices of numbers: double, single, int8 to uint64."""

COMPLEX = 0x0800
"""Flag of a matrix with an imaginary part."""

LARGEST = 2**31
"""Largest size of a decompressed element, bytes."""


class Hdf5Version(ValueError):
    """The file has version 7.3, which is HDF5."""


class _Element(NamedTuple):
    kind: int
    data: bytes


def mat_matrices(content: bytes) -> dict[str, FloatArray]:
    """Name -> full real matrix of each variable; other variables are left out.

    Raises
    ------
    Hdf5Version
        If the file has version 7.3.
    ValueError
        If the file is damaged, cut off, or no MATLAB file of version 5 to 7.2.
    """
    if len(content) < HEADER:
        raise ValueError("no header of version 5")
    order = {b"IM": "<", b"MI": ">"}.get(content[126:128])
    if order is None:
        raise ValueError("no header of version 5")
    version = struct.unpack(order + "H", content[124:126])[0]
    if version == 0x0200:
        raise Hdf5Version("version 7.3")
    if version != 0x0100:
        raise ValueError(f"version {version:#x} in the header")
    found: dict[str, FloatArray] = {}
    for element in _elements(content[HEADER:], order):
        matrix = element
        if element.kind == COMPRESSED:
            (matrix,) = _elements(_decompressed(element.data), order)
        if matrix.kind != MATRIX:
            raise ValueError(f"element of type {matrix.kind} in place of a matrix")
        read = _matrix(matrix.data, order)
        if read is not None:
            found[read[0]] = read[1]
    return found


def _elements(data: bytes, order: str) -> Iterator[_Element]:
    """Elements of a sequence, each a tag and its data, padded to eight bytes unless compressed."""
    at = 0
    while at < len(data):
        if len(data) - at < 8:
            raise ValueError("cut off within a tag")
        kind, size = struct.unpack(order + "II", data[at : at + 8])
        start = at + 8
        if kind >> 16:  # small element: type, size and up to four bytes in one tag
            kind, size, start = kind & 0xFFFF, kind >> 16, at + 4
            if size > 4:
                raise ValueError("small element of more than four bytes")
        end = start + size
        if end > len(data):
            raise ValueError("cut off within an element")
        yield _Element(kind, data[start:end])
        at = end if kind == COMPRESSED else -(-end // 8) * 8


def _decompressed(data: bytes) -> bytes:
    try:
        stream = zlib.decompressobj()
        found = stream.decompress(data, LARGEST)
    except zlib.error as error:
        raise ValueError(str(error)) from None
    if not stream.eof or stream.unconsumed_tail:
        raise ValueError("compressed variable is cut off or too large")
    return found


def _matrix(data: bytes, order: str) -> tuple[str, FloatArray] | None:
    """Name and values of a variable; None if it is no full real matrix."""
    parts = list(_elements(data, order))
    if len(parts) < 3 or parts[0].kind != 6 or len(parts[0].data) != 8 or parts[1].kind != 5 or parts[2].kind != 1:
        raise ValueError("variable without flags, dimensions or name")
    flags = struct.unpack(order + "I", parts[0].data[:4])[0]
    if flags & 0xFF not in NUMERIC or flags & COMPLEX:
        return None
    shape = [int(n) for n in np.frombuffer(parts[1].data, dtype=order + "i4")]
    name = parts[2].data.decode("ascii")
    if len(parts) != 4 or parts[3].kind not in NUMBERS or any(n < 0 for n in shape):
        raise ValueError(f"variable {name!r} has no numbers")
    values = np.frombuffer(parts[3].data, dtype=order + NUMBERS[parts[3].kind])
    if values.size != prod(shape):
        raise ValueError(f"variable {name!r} has {values.size} numbers, not {prod(shape)}")
    return name, values.astype(np.float64).reshape(shape, order="F")
