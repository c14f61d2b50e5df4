"""Two networks of the same form in one file: one answers for ground in kelvin and metres, the other for pictures.

    python -m tools.train.join GROUND.onnx PICTURES.onnx OUT.onnx

A vector's last number says which it is (`rover.detection.patch`). A network for ground alone reads the first numbers of
the vector and knows nothing of the rest.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
import onnx
from onnx import TensorProto, helper, numpy_helper
from rover.detection.patch import LENGTH

CLASSES = 4


def input_length(model: onnx.ModelProto) -> int:
    """How many numbers a candidate has for this network."""
    return int(model.graph.input[0].type.tensor_type.shape.dim[1].dim_value)


def renamed(model: onnx.ModelProto, prefix: str, source: str) -> tuple[list[onnx.NodeProto], list[TensorProto], str]:
    """The network's nodes and weights under names of their own, reading `source`; and the name of what it answers."""
    begin = model.graph.input[0].name

    def name(old: str) -> str:
        return source if old == begin else f"{prefix}{old}"

    weights = []
    for stored in model.graph.initializer:
        weight = TensorProto()
        weight.CopyFrom(stored)
        weight.name = name(stored.name)
        weights.append(weight)
    nodes = []
    for number, stored in enumerate(model.graph.node):
        node = onnx.NodeProto()
        node.CopyFrom(stored)
        node.name = f"{prefix}{number}"
        del node.input[:], node.output[:]
        node.input.extend(name(old) for old in stored.input)
        node.output.extend(name(old) for old in stored.output)
        nodes.append(node)
    return nodes, weights, name(model.graph.output[0].name)


def join(ground: onnx.ModelProto, pictures: onnx.ModelProto) -> onnx.ModelProto:
    """One model (candidates, LENGTH) to (candidates, classes) of both. Raises ValueError when the lengths don't fit."""
    if input_length(pictures) != LENGTH or input_length(ground) > LENGTH:
        raise ValueError(f"inputs of {input_length(ground)} and {input_length(pictures)} numbers, {LENGTH} expected")
    ground_nodes, ground_weights, from_ground = renamed(ground, "ground_", "ground_part")
    picture_nodes, picture_weights, from_pictures = renamed(pictures, "picture_", "vectors")
    constants = [
        numpy_helper.from_array(np.array([value]), key)
        for key, value in (("begin", 0), ("end", input_length(ground)), ("axis", 1), ("flag_at", LENGTH - 1))
    ]
    constants.append(numpy_helper.from_array(np.array([0.5], np.float32), "half"))
    nodes = [
        helper.make_node("Slice", ["vectors", "begin", "end", "axis"], ["ground_part"]),
        *ground_nodes,
        *picture_nodes,
        helper.make_node("Gather", ["vectors", "flag_at"], ["flag"], axis=1),
        helper.make_node("Greater", ["flag", "half"], ["is_picture"]),
        helper.make_node("Where", ["is_picture", from_pictures, from_ground], ["probabilities"]),
    ]
    graph = helper.make_graph(
        nodes,
        "landmine_mlp",
        [helper.make_tensor_value_info("vectors", TensorProto.FLOAT, ["candidates", LENGTH])],
        [helper.make_tensor_value_info("probabilities", TensorProto.FLOAT, ["candidates", CLASSES])],
        ground_weights + picture_weights + constants,
    )
    joined = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 17)], ir_version=8)
    notes = {item.key: item.value for item in pictures.metadata_props}
    helper.set_model_props(joined, notes | {"input_length": str(LENGTH)})
    onnx.checker.check_model(joined)
    return joined


def main() -> None:
    """See the module."""
    parser = argparse.ArgumentParser(description="Joins a network for ground and one for pictures in one file.")
    for name in ("ground", "pictures", "out"):
        parser.add_argument(name, type=Path)
    options = parser.parse_args()
    onnx.save(join(onnx.load(options.ground), onnx.load(options.pictures)), options.out)


if __name__ == "__main__":
    main()
