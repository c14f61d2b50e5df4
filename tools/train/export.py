"""The trained network as one ONNX file: standardiser folded into the first layer, temperature into the last."""

from __future__ import annotations

import hashlib
from pathlib import Path

import numpy as np
import onnx
from numpy.typing import NDArray
from onnx import TensorProto, helper, numpy_helper
from rover.detection.classifier import CLASSES
from rover.detection.patch import LENGTH

from tools.train.network import Network

Layer = tuple[NDArray[np.float32], NDArray[np.float32]]


def fold(
    weights: list[NDArray[np.float64]],
    biases: list[NDArray[np.float64]],
    mean: NDArray[np.float64],
    scale: NDArray[np.float64],
    temperature: float,
) -> list[Layer]:
    """Layers (in, out) that take raw vectors and give logits that are already divided by the temperature."""
    layers = [(w.astype(np.float64), b.astype(np.float64)) for w, b in zip(weights, biases, strict=True)]
    first, bias = layers[0]
    layers[0] = (first / scale[:, None], bias - (mean / scale) @ first)
    last, bias = layers[-1]
    layers[-1] = (last / temperature, bias / temperature)
    return [(w.astype(np.float32), b.astype(np.float32)) for w, b in layers]


def read(path: Path) -> Network:
    """The network of a model file that `write` has made; its standardiser is folded in already."""
    model = onnx.load(path)
    stored = {i.name: numpy_helper.to_array(i).astype(np.float32) for i in model.graph.initializer}
    notes = {p.key: p.value for p in model.metadata_props}
    layers = range(sum(name.startswith("weight") for name in stored))
    weights, biases = [stored[f"weight{i}"] for i in layers], [stored[f"bias{i}"] for i in layers]
    temperature = np.float32(notes.get("temperature", 1.0))
    weights[-1], biases[-1] = weights[-1] * temperature, biases[-1] * temperature
    length = weights[0].shape[0]
    return Network(weights, biases, np.zeros(length), np.ones(length), tuple(range(len(CLASSES))))


def write(
    path: Path, layers: list[Layer], notes: dict[str, str], pictures: tuple[float, NDArray[np.float32]] | None = None
) -> None:
    """Writes the model; metadata: classes, input length, and `notes`.

    pictures: factor and offsets (classes,) of the logits of pictures without kelvin, whose last number is 1: they have
    a calibration of their own.
    """
    nodes, initializers = [], []
    flow = "vectors"
    for index, (weight, bias) in enumerate(layers):
        # Weights as float16 halve the file; they are widened again when the model is loaded.
        initializers.append(numpy_helper.from_array(weight.astype(np.float16), f"weight{index}"))
        initializers.append(numpy_helper.from_array(bias, f"bias{index}"))
        nodes.append(helper.make_node("Cast", [f"weight{index}"], [f"wide{index}"], to=TensorProto.FLOAT))
        nodes.append(helper.make_node("Gemm", [flow, f"wide{index}", f"bias{index}"], [f"sum{index}"]))
        flow = f"sum{index}"
        if index < len(layers) - 1:
            nodes.append(helper.make_node("Relu", [flow], [f"hidden{index}"]))
            flow = f"hidden{index}"
    if pictures is not None:
        flow = _calibrated(nodes, initializers, flow, *pictures)
    nodes.append(helper.make_node("Softmax", [flow], ["probabilities"], axis=1))
    graph = helper.make_graph(
        nodes,
        "landmine_mlp",
        [helper.make_tensor_value_info("vectors", TensorProto.FLOAT, ["candidates", LENGTH])],
        [helper.make_tensor_value_info("probabilities", TensorProto.FLOAT, ["candidates", len(CLASSES)])],
        initializers,
    )
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 17)], ir_version=8)
    helper.set_model_props(model, {"classes": ",".join(CLASSES), "input_length": str(LENGTH), **notes})
    onnx.checker.check_model(model)
    path.parent.mkdir(parents=True, exist_ok=True)
    content = model.SerializeToString()
    path.write_bytes(content)
    # The rover refuses a model that is not the one that was evaluated.
    path.with_suffix(".sha256").write_text(f"{hashlib.sha256(content).hexdigest()}  {path.name}\n", encoding="ascii")


def _calibrated(nodes: list, initializers: list, flow: str, factor: float, offsets: NDArray[np.float32]) -> str:
    """logits · (1 + flag·(factor − 1)) + flag·offsets, the flag being the last number of the vector."""
    initializers += [
        numpy_helper.from_array(np.array([LENGTH - 1]), "flag_at"),
        numpy_helper.from_array(np.array([factor - 1.0], np.float32), "factor"),
        numpy_helper.from_array(np.array([1.0], np.float32), "one"),
        numpy_helper.from_array(offsets.astype(np.float32).reshape(1, -1), "offsets"),
    ]
    nodes += [
        helper.make_node("Gather", ["vectors", "flag_at"], ["flag"], axis=1),
        helper.make_node("Mul", ["flag", "factor"], ["more"]),
        helper.make_node("Add", ["more", "one"], ["scale"]),
        helper.make_node("Mul", [flow, "scale"], ["scaled"]),
        helper.make_node("MatMul", ["flag", "offsets"], ["shift"]),
        helper.make_node("Add", ["scaled", "shift"], ["calibrated"]),
    ]
    return "calibrated"
