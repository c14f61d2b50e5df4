"""Specification: weights are read without PyTorch, folded exactly, and the file that ships is what they give."""

from __future__ import annotations

import io
import pickle
import struct
import sys
from collections import OrderedDict
from pathlib import Path
from types import ModuleType

import numpy as np
import onnx
import pytest
from rover.detection.model_file import shipped
from rover.detection.picture.features import FILE
from rover.errors import BadInput

from tools.train.backbone.checkpoint import MAGIC, read_checkpoint
from tools.train.backbone.graph import EPSILON, features_model, fold_norm
from tools.train.backbone.make import packaged


class Reference:
    """Stands for a storage in a pickle."""

    def __init__(self, *parts: object) -> None:
        self.parts = ("storage", *parts)


class Written(pickle.Pickler):
    def persistent_id(self, thing: object) -> object:
        return thing.parts if isinstance(thing, Reference) else None


def checkpoint(file: Path, tensors: object, storages: dict[str, np.ndarray]) -> Path:
    """A file as PyTorch before 1.6 wrote it."""
    out = io.BytesIO()
    for part in (MAGIC, 1001, {"little_endian": True}, tensors, sorted(storages)):
        Written(out, 2).dump(part)
    for key in sorted(storages):
        out.write(struct.pack("<q", len(storages[key])) + storages[key].tobytes())
    file.write_bytes(out.getvalue())
    return file


@pytest.fixture
def torch(monkeypatch: pytest.MonkeyPatch) -> dict[str, type]:
    """The names that such files hold, for pickling alone."""
    named = {}
    modules = {name: ModuleType(name) for name in ("torch", "torch._utils")}
    for name, module in modules.items():
        monkeypatch.setitem(sys.modules, name, module)
    for name, place in (("FloatStorage", "torch"), ("LongStorage", "torch"), ("_rebuild_tensor_v2", "torch._utils")):
        named[name] = type(name, (), {"__module__": place, "__qualname__": name})
        setattr(modules[place], name, named[name])
    return named


class Tensor:
    """Pickles as PyTorch's tensors do."""

    def __init__(self, rebuild: object, *parts: object) -> None:
        self.rebuild, self.parts = rebuild, parts

    def __reduce__(self) -> tuple[object, ...]:
        return self.rebuild, (*self.parts, False, OrderedDict())


def test_tensors_are_read_through_their_strides(tmp_path: Path, torch: dict[str, type]) -> None:
    storage = Reference(torch["FloatStorage"], "7", "cpu", 8, None)
    numbers = np.arange(8, dtype=np.float32)
    parts = {"plain": (2, (2, 3), (3, 1)), "turned": (2, (3, 2), (1, 3)), "beyond": (3, (2, 3), (3, 1))}
    made = {name: Tensor(torch["_rebuild_tensor_v2"], storage, *part) for name, part in parts.items()}
    beyond = made.pop("beyond")
    found = read_checkpoint(checkpoint(tmp_path / "a.pth", OrderedDict(made), {"7": numbers}))
    assert np.array_equal(found["plain"], [[2, 3, 4], [5, 6, 7]])
    assert np.array_equal(found["turned"], found["plain"].T)
    with pytest.raises(BadInput, match="a tensor reaches beyond its storage"):
        read_checkpoint(checkpoint(tmp_path / "b.pth", OrderedDict(beyond=beyond), {"7": numbers}))


def test_a_file_that_is_no_checkpoint_is_refused_in_one_line(tmp_path: Path) -> None:
    file = tmp_path / "a.pth"
    for content in (b"", b"PK\x03\x04 a zip", pickle.dumps(12)):
        file.write_bytes(content)
        with pytest.raises(BadInput, match=r"a\.pth: not weights as PyTorch before 1\.6 saved them"):
            read_checkpoint(file)


def test_a_checkpoint_runs_no_code_of_others(tmp_path: Path) -> None:
    file = checkpoint(tmp_path / "a.pth", OrderedDict(weight=Path("x")), {})
    with pytest.raises(BadInput, match="is no part of a file of weights"):
        read_checkpoint(file)


def test_a_folded_kernel_does_what_kernel_and_normalisation_do() -> None:
    rng = np.random.default_rng(1)
    kernel, flow = rng.normal(size=(5, 3, 1, 1)).astype(np.float32), rng.normal(size=(3, 40))
    norm = {f"n.{part}": rng.uniform(0.5, 2.0, 5) for part in ("weight", "bias", "running_mean", "running_var")}
    folded, bias = fold_norm(kernel, norm, "n")
    plain = kernel[:, :, 0, 0] @ flow
    gain = norm["n.weight"] / np.sqrt(norm["n.running_var"] + EPSILON)
    wanted = (plain - norm["n.running_mean"][:, None]) * gain[:, None] + norm["n.bias"][:, None]
    assert folded[:, :, 0, 0] @ flow + bias[:, None] == pytest.approx(wanted, abs=1e-5)


def test_the_file_that_ships_is_what_the_package_s_weights_give() -> None:
    try:
        file = packaged()
    except BadInput as error:
        pytest.skip(str(error))
    weights = read_checkpoint(file)
    content = features_model(weights, {}).graph.SerializeToString()
    assert content == onnx.load(shipped(FILE)).graph.SerializeToString()
