"""The first stages of EfficientNet-Lite0 as an ONNX graph for grey pictures, batch normalisation folded in.

Tan and Le, "EfficientNet: Rethinking Model Scaling for Convolutional Neural Networks", 2019; the Lite variants have
no squeeze and excitation, and ReLU6 in place of swish.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import onnx
from numpy.typing import NDArray
from onnx import TensorProto, helper, numpy_helper
from rover.detection.picture.features import CHANNELS

# Kernel and stride of every stage that is kept.
STAGES = ((3, 1), (3, 2), (3, 1), (5, 2), (5, 1), (3, 2), (3, 1), (3, 1))
EPSILON = 1e-3

Weights = Mapping[str, NDArray[Any]]


class _Graph:
    """Nodes and weights, layer by layer."""

    def __init__(self, weights: Weights) -> None:
        self.weights = weights
        self.nodes: list[onnx.NodeProto] = []
        self.initializers = [numpy_helper.from_array(np.float32(value), name) for name, value in (("0", 0), ("6", 6))]

    def convolve(self, flow: str, layer: str, kernel: NDArray[Any], norm: str, stride: int, act: bool) -> str:
        """A convolution with its batch normalisation, padded alike on both sides; then ReLU6 where `act`."""
        folded, bias = fold_norm(kernel, self.weights, norm)
        groups = len(kernel) if kernel.shape[1] == 1 and layer != "stem" else 1
        # float16 halves the file; the weights are widened when it is loaded.
        self.initializers += [
            numpy_helper.from_array(folded.astype(np.float16), f"{layer}.kernel"),
            numpy_helper.from_array(bias, f"{layer}.bias"),
        ]
        side = kernel.shape[2]
        self.add("Cast", [f"{layer}.kernel"], f"{layer}.wide", to=TensorProto.FLOAT)
        inputs = [flow, f"{layer}.wide", f"{layer}.bias"]
        self.add(
            "Conv", inputs, layer, kernel_shape=[side] * 2, strides=[stride] * 2, pads=[side // 2] * 4, group=groups
        )
        return self.add("Clip", [layer, "0", "6"], f"{layer}.act") if act else layer

    def add(self, operator: str, inputs: list[str], output: str, **attributes: Any) -> str:
        """One node."""
        self.nodes.append(helper.make_node(operator, inputs, [output], **attributes))
        return output


def fold_norm(kernel: NDArray[Any], weights: Weights, norm: str) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Kernel (out, in, h, w) and bias (out,) that do what the kernel and batch normalisation `norm` do together."""
    gain, shift, mean, variance = (
        weights[f"{norm}.{part}"].astype(np.float64) for part in ("weight", "bias", "running_mean", "running_var")
    )
    scale = gain / np.sqrt(variance + EPSILON)
    return (kernel * scale[:, None, None, None]).astype(np.float32), (shift - mean * scale).astype(np.float32)


def features_model(weights: Weights, notes: dict[str, str]) -> onnx.ModelProto:
    """`grey` (1, 1, h, w), which stands for red, green and blue, and `shares` (N, cells) to `features` (N, CHANNELS):
    for every row the mean over cells of 16 x 16 pixels that count for their shares."""
    graph = _Graph(weights)
    stem = weights["_conv_stem.weight"].sum(axis=1, keepdims=True)
    flow = graph.convolve("grey", "stem", stem, "_bn0", 2, True)
    for number, (side, stride) in enumerate(STAGES):
        name, begin = f"_blocks.{number}", flow
        if number:
            flow = graph.convolve(
                flow, f"{number}.expand", weights[f"{name}._expand_conv.weight"], f"{name}._bn0", 1, True
            )
        depthwise, project = (weights[f"{name}.{part}.weight"] for part in ("_depthwise_conv", "_project_conv"))
        assert depthwise.shape[2] == side
        flow = graph.convolve(flow, f"{number}.depthwise", depthwise, f"{name}._bn1", stride, True)
        flow = graph.convolve(flow, f"{number}.project", project, f"{name}._bn2", 1, False)
        if number and stride == 1 and len(project) == weights[f"{name}._expand_conv.weight"].shape[1]:
            flow = graph.add("Add", [flow, begin], f"{number}.sum")
    # Means are taken in here, since onnxruntime keeps to one thread where numpy may wake all of them.
    graph.initializers.append(numpy_helper.from_array(np.array((CHANNELS, -1), np.int64), "flat"))
    graph.add("Reshape", [flow, "flat"], "by_channel")
    graph.add("Transpose", ["by_channel"], "by_cell", perm=[1, 0])
    graph.add("MatMul", ["shares", "by_cell"], "features")
    told = helper.make_graph(
        graph.nodes,
        "picture_features",
        [
            helper.make_tensor_value_info("grey", TensorProto.FLOAT, [1, 1, "h", "w"]),
            helper.make_tensor_value_info("shares", TensorProto.FLOAT, ["places", "cells"]),
        ],
        [helper.make_tensor_value_info("features", TensorProto.FLOAT, ["places", CHANNELS])],
        graph.initializers,
    )
    model = helper.make_model(told, opset_imports=[helper.make_opsetid("", 17)], ir_version=8)
    helper.set_model_props(model, notes)
    onnx.checker.check_model(model)
    return model
