"""Reads weights that PyTorch before 1.6 has saved, without PyTorch.

Such a file is a row of pickles - a magic number, the version, sizes of types, the tensors by name with references to
storages, the storages' keys - and then each storage: its length in eight bytes, little-endian, and its numbers.
"""

from __future__ import annotations

import pickle
import struct
from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray
from rover.errors import BadInput

MAGIC = 0x1950A86A20F9469CFC6C
TYPES: dict[str, np.dtype[Any]] = {"FloatStorage": np.dtype("<f4"), "LongStorage": np.dtype("<i8")}


@dataclass
class _Storage:
    kind: np.dtype[Any]
    numbers: NDArray[Any] | None = None


@dataclass(frozen=True)
class _Tensor:
    """A view of a storage; offset and strides in numbers."""

    storage: _Storage
    offset: int
    size: tuple[int, ...]
    strides: tuple[int, ...]

    def numbers(self) -> NDArray[Any]:
        flat = self.storage.numbers
        reach = self.offset + sum((n - 1) * s for n, s in zip(self.size, self.strides, strict=True)) + 1
        if flat is None or reach > len(flat):
            raise ValueError("a tensor reaches beyond its storage")
        strides = [stride * flat.itemsize for stride in self.strides]
        view: NDArray[Any] = np.lib.stride_tricks.as_strided(flat[self.offset :], self.size, strides)
        return np.array(view)


class _Tensors(pickle.Unpickler):
    """Makes nothing but ordered tables, tensors and storages: other classes in a file are an error."""

    def __init__(self, file: BinaryIO) -> None:
        super().__init__(file)
        self.storages: dict[str, _Storage] = {}

    def find_class(self, module: str, name: str) -> Any:
        known: dict[tuple[str, str], Callable[..., Any]] = {
            ("collections", "OrderedDict"): OrderedDict,
            ("torch._utils", "_rebuild_tensor_v2"): lambda storage, offset, size, strides, *_: _Tensor(
                storage, offset, tuple(size), tuple(strides)
            ),
        }
        if module == "torch" and name in TYPES:
            return name
        if (module, name) not in known:
            raise pickle.UnpicklingError(f"{module}.{name} is no part of a file of weights")
        return known[module, name]

    def persistent_load(self, reference: Any) -> _Storage:
        _, kind, key, *_ = reference
        return self.storages.setdefault(key, _Storage(TYPES[kind]))


def read_checkpoint(file: Path) -> dict[str, NDArray[Any]]:
    """Tensors by name. Raises BadInput where the file is none of this form."""
    try:
        with file.open("rb") as stream:
            return _read(stream)
    except (OSError, ValueError, TypeError, KeyError, EOFError, struct.error, pickle.UnpicklingError) as error:
        raise BadInput(f"{file}: not weights as PyTorch before 1.6 saved them ({error})") from error


def _read(stream: BinaryIO) -> dict[str, NDArray[Any]]:
    if _Tensors(stream).load() != MAGIC:
        raise ValueError("another magic number")
    for _ in ("version", "sizes of types"):
        _Tensors(stream).load()
    reader = _Tensors(stream)
    tensors = reader.load()
    for key in _Tensors(stream).load():
        storage = reader.storages[key]
        (count,) = struct.unpack("<q", stream.read(8))
        storage.numbers = np.frombuffer(stream.read(count * storage.kind.itemsize), storage.kind)
    return {name: tensor.numbers() for name, tensor in tensors.items()}
