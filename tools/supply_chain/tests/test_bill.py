"""The bill of materials holds every crate and package of the locks, and is the same whenever it is made."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from tools.supply_chain.bill import bill
from tools.supply_chain.component import Component
from tools.supply_chain.crates import WORKSPACES, crates
from tools.supply_chain.python_packages import packages

ROOT = Path(__file__).parents[3]
MODELS = sorted((ROOT / "companion" / "models").glob("*.onnx"))


def made(components: Iterable[Component]) -> str:
    return bill(components, MODELS, "0.1.0", "c0ffee", 1_700_000_000)


def test_every_crate_and_package_of_the_locks_is_in_it_with_licence_and_hashes() -> None:
    components = crates(ROOT) | packages(ROOT, "run")
    document: dict[str, Any] = json.loads(made(components))
    assert (document["bomFormat"], document["specVersion"]) == ("CycloneDX", "1.6")
    libraries = {each["purl"]: each for each in document["components"] if each["type"] == "library"}
    for workspace in WORKSPACES:
        lock = (ROOT / workspace / "Cargo.lock").read_text()
        for name, version, source in re.findall(r'name = "(.+)"\nversion = "(.+)"(?:\nsource = "(.+)")?', lock):
            assert (f"pkg:cargo/{name}@{version}" in libraries) == bool(source), name
    assert {f"pkg:pypi/{each.name}@{each.version}" for each in packages(ROOT, "run")} <= libraries.keys()
    for url, library in libraries.items():
        assert library["licenses"], url
        assert library["externalReferences"][0]["hashes"], url
    networks = {each["name"] for each in document["components"] if each["type"] == "machine-learning-model"}
    assert networks == {model.name for model in MODELS}
    everything = {each["bom-ref"] for each in document["components"]}
    assert {frozenset(each["dependsOn"]) for each in document["dependencies"] if each["ref"] == "rover"} == {
        frozenset(everything)
    }


def test_it_is_the_same_bytes_each_time() -> None:
    some = [Component("cargo", f"crate{number}", "1.0.0", "MIT OR Apache-2.0", ("0" * 64,)) for number in range(50)]
    assert made(some) == made(some[::-1])
    assert made(some) != made(some[1:])
