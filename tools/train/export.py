"""The trained network as one ONNX file: standardiser folded into the first layer, calibration into the last."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import onnx
from numpy.typing import NDArray
from onnx import TensorProto, helper, numpy_helper
from rover.detection.classifier import CLASSES, LENGTHS

from tools.train.network import Layer


def fold(
    weights: Sequence[NDArray[np.floating]],
    biases: Sequence[NDArray[np.floating]],
    mean: NDArray[np.float64],
    scale: NDArray[np.float64],
    factor: float,
    offsets: NDArray[np.floating] | float = 0.0,
) -> list[Layer]:
    """Layers (in, out) that take raw vectors and give calibrated logits: times `factor`, plus `offsets` (classes,)."""
    layers = [(w.astype(np.float64), b.astype(np.float64)) for w, b in zip(weights, biases, strict=True)]
    first, bias = layers[0]
    layers[0] = (first / scale[:, None], bias - (mean / scale) @ first)
    last, bias = layers[-1]
    layers[-1] = (last * factor, bias * factor + offsets)
    return [(w.astype(np.float32), b.astype(np.float32)) for w, b in layers]


def write(path: Path, kind: str, layers: list[Layer], notes: dict[str, str]) -> str:
    """Writes the model and its hash beside it; metadata: kind, classes, input length, and `notes`. Returns the hash."""
    nodes, initializers = [], []
    flow = "vectors"
    for index, (weight, bias) in enumerate(layers):
        is_last = index == len(layers) - 1
        # Weights as float16 halve the file; they are widened again when the model is loaded. The last are few.
        stored = weight.astype(np.float32 if is_last else np.float16)
        initializers.append(numpy_helper.from_array(stored, f"weight{index}"))
        initializers.append(numpy_helper.from_array(bias, f"bias{index}"))
        nodes.append(helper.make_node("Cast", [f"weight{index}"], [f"wide{index}"], to=TensorProto.FLOAT))
        nodes.append(helper.make_node("Gemm", [flow, f"wide{index}", f"bias{index}"], [f"sum{index}"]))
        flow = f"sum{index}"
        if not is_last:
            nodes.append(helper.make_node("Relu", [flow], [f"hidden{index}"]))
            flow = f"hidden{index}"
    nodes.append(helper.make_node("Softmax", [flow], ["probabilities"], axis=1))
    graph = helper.make_graph(
        nodes,
        f"landmine_{kind}",
        [helper.make_tensor_value_info("vectors", TensorProto.FLOAT, ["candidates", LENGTHS[kind]])],
        [helper.make_tensor_value_info("probabilities", TensorProto.FLOAT, ["candidates", len(CLASSES)])],
        initializers,
    )
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 17)], ir_version=8)
    told = {"kind": kind, "classes": ",".join(CLASSES), "input_length": str(LENGTHS[kind]), **notes}
    helper.set_model_props(model, told)
    onnx.checker.check_model(model)
    return write_file(path, model)


def write_file(path: Path, model: onnx.ModelProto) -> str:
    """Writes the model and its hash beside it; returns the hash."""
    path.parent.mkdir(parents=True, exist_ok=True)
    content = model.SerializeToString()
    path.write_bytes(content)
    # The rover refuses a model that is not the one that was evaluated.
    found = hashlib.sha256(content).hexdigest()
    path.with_suffix(".sha256").write_text(f"{found}  {path.name}\n", encoding="ascii")
    return found
