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


def write(path: Path, layers: list[Layer], notes: dict[str, str]) -> None:
    """Writes the model; metadata: classes, input length, and `notes`."""
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
